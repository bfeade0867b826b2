"""The space around a robot: a floor, and the obstacles on it that are not on the map."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose

LOOK_STEP = 20.0        # mm between the examined points of a straight


@dataclass(frozen=True)
class Disc:
    """A round obstacle that moves or is temporary, in mm."""

    x: float
    y: float
    radius: float


class Space:
    """A floor with temporary obstacles on it."""

    def __init__(self, floor: SimFloor, obstacles: Sequence[Disc]) -> None:
        self.floor = floor
        self.obstacles = list(obstacles)

    def clearance_at(self, points: np.ndarray) -> np.ndarray:
        """Returns the distance (mm) from each point (N, 2) to the nearest obstacle."""
        points = np.asarray(points, float).reshape(-1, 2)
        clear = self.floor.clearance_at(points)
        for disc in self.obstacles:
            away = np.hypot(points[:, 0] - disc.x, points[:, 1] - disc.y) - disc.radius
            clear = np.minimum(clear, np.maximum(away, 0.0))
        return clear

    def clearance_of(self, x: float, y: float) -> float:
        """Returns the clearance of one point."""
        return float(self.clearance_at(np.array([[x, y]]))[0])

    def clearance_along(self, starts: np.ndarray, ends: np.ndarray, fractions: np.ndarray
                        ) -> np.ndarray:
        """Returns the least clearance (N,) on each straight from `starts` to `ends` (N, 2).

        The clearance is examined at `fractions` of each straight. If there is only one start or
        end, it belongs to all straights.
        """
        points = starts[:, None] + fractions[:, None] * (ends - starts)[:, None]
        return self.clearance_at(points).reshape(points.shape[:2]).min(axis=1)

    def straight_is_free(self, a: np.ndarray, b: np.ndarray, clearance: float) -> bool:
        """Returns whether the straight from a to b has at least `clearance` everywhere."""
        count = int(np.hypot(*(b - a)) / LOOK_STEP) + 2
        return bool(self.clearance_along(a[None], b[None], np.linspace(0.0, 1.0, count))[0]
                    >= clearance)

    def body_fits(self, pose: SimPose, margin: float) -> bool:
        """Returns whether the whole body, with `margin` mm around it, is free at `pose`."""
        corners = self.floor.body.corners(pose)
        outline = np.concatenate([np.linspace(a, b, 15) for a, b in
                                  zip(corners, np.roll(corners, -1, axis=0))])
        return bool(self.clearance_at(outline).min() >= margin)
