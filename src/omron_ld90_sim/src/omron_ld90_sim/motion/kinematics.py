"""The LD-90's body and its limits, from its data sheet and from real robots' configurations.

The units are millimetres, degrees and seconds, as in ARCL and the robot's own configuration.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence, Tuple, Union

import numpy as np

Points = Union[np.ndarray, Sequence[Tuple[float, float]]]     # (N, 2)


def normalise(angle: float) -> float:
    """Returns the angle (deg) in (-180, 180]."""
    angle = math.fmod(angle, 360.0)
    if angle <= -180.0:
        return angle + 360.0
    return angle - 360.0 if angle > 180.0 else angle


@dataclass(frozen=True)
class SimPose:
    """A position and heading in the map frame: mm, mm, degrees in (-180, 180]."""

    x: float
    y: float
    theta: float

    def ahead(self, distance: float) -> SimPose:
        """Returns the pose `distance` mm straight ahead (behind when negative)."""
        angle = math.radians(self.theta)
        return SimPose(self.x + distance * math.cos(angle), self.y + distance * math.sin(angle),
                       self.theta)

    def distance_to(self, x: float, y: float) -> float:
        """Returns the distance (mm) to a point."""
        return math.hypot(x - self.x, y - self.y)


@dataclass(frozen=True)
class Body:
    """The robot's outline, a rectangle around its turning centre (mm)."""

    length: float = 699.0
    width: float = 500.0

    @property
    def half_width(self) -> float:
        """Free space that is needed at each side while driving straight."""
        return self.width / 2

    @property
    def half_length(self) -> float:
        """The distance from the turning centre to the front."""
        return self.length / 2

    @property
    def half_diagonal(self) -> float:
        """Free space that is needed all around while turning."""
        return math.hypot(self.length, self.width) / 2

    def corners(self, pose: SimPose) -> np.ndarray:
        """Returns the four corners (4, 2) at `pose`, counter-clockwise from the front left."""
        return self.outlines([pose])[0]

    def outlines(self, poses: Sequence[SimPose]) -> np.ndarray:
        """Returns the corners at each of K poses (K, 4, 2)."""
        x, y, angle = np.array([(pose.x, pose.y, math.radians(pose.theta))
                                for pose in poses]).T[:, :, None]
        ahead = self.half_length * np.array([1, -1, -1, 1])
        left = self.half_width * np.array([1, 1, -1, -1])
        return np.stack([x + ahead * np.cos(angle) - left * np.sin(angle),
                         y + ahead * np.sin(angle) + left * np.cos(angle)], axis=-1)

    def distances(self, poses: Sequence[SimPose], points: Points) -> np.ndarray:
        """Returns the distances (M, N) in mm from the body at each of M poses to each of N points;
        0: the point is inside the body.
        """
        at = np.array([(pose.x, pose.y, math.radians(pose.theta)) for pose in poses])
        x, y = (np.asarray(points, float).T[:, None, :] - at[:, :2].T[:, :, None])
        cosine, sine = np.cos(at[:, 2, None]), np.sin(at[:, 2, None])
        ahead = np.abs(x * cosine + y * sine) - self.half_length
        aside = np.abs(y * cosine - x * sine) - self.half_width
        return np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))


@dataclass(frozen=True)
class Limits:
    """Speeds (mm/s, deg/s) and accelerations (mm/s2, deg/s2)."""

    speed: float = 1350.0
    reverse_speed: float = 300.0
    docking_speed: float = 150.0
    acceleration: float = 500.0
    deceleration: float = 500.0
    goal_deceleration: float = 200.0
    emergency_deceleration: float = 2000.0
    path_rotation: float = 100.0
    goal_rotation: float = 50.0
    rotation_acceleration: float = 180.0


LD90_BODY = Body()
LD90_LIMITS = Limits()
