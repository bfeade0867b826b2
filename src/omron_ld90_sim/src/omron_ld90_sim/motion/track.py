"""Tracks, which are smooth lines with a speed for every place, and turns on the spot.

The speed along a track is the highest that the limits allow. After the start, the acceleration
limits the speed; before the end, the deceleration limits it. Towards a goal the deceleration is
lower.
"""
from __future__ import annotations

import bisect
import math
from dataclasses import dataclass
from typing import List, Optional, Tuple, Union, cast

import numpy as np

from omron_ld90_sim.motion.kinematics import LD90_LIMITS, Limits, SimPose, normalise

STRAIGHT_STEP = 100.0       # mm between samples


@dataclass(frozen=True)
class Turn:
    """A turn on the spot to a heading (deg) at up to `rate` deg/s, in the shorter direction.

    If `angle` (deg, left positive) is given, the robot turns by this angle instead, even if it is
    more than a whole turn.
    """

    heading: float
    rate: float
    angle: Optional[float] = None


class SmoothTrack:
    """A smooth line driven without stopping.

    `samples` (N, 4): x, y (mm), driving direction (rad, unwrapped), curvature (1/mm).
    """

    def __init__(self, samples: np.ndarray, limits: Limits = LD90_LIMITS, reverse: bool = False,
                 final: bool = True, top_speed: Optional[float] = None,
                 entry_speed: float = 0.0) -> None:
        self.samples, self.reverse = samples, reverse
        steps = np.hypot(np.diff(samples[:, 0]), np.diff(samples[:, 1]))
        keep = np.concatenate([[True], steps > 1e-6])
        self.samples = samples = samples[keep]
        distances = np.concatenate([[0.0], np.cumsum(steps[steps > 1e-6])])
        self.length = float(distances[-1])
        self.entry_fits = True      # whether the limits allow the entry speed
        self._s = cast(List[float], distances.tolist())
        self._v2 = self._profile(limits, distances, final, top_speed or limits.speed, entry_speed)
        self._rows = cast(List[List[float]], samples.tolist())

    def _profile(self, limits: Limits, s: np.ndarray, final: bool, top_speed: float,
                 entry_speed: float) -> List[float]:
        """Returns the squares of the highest speeds at the samples."""
        curvature = np.abs(self.samples[:, 3])
        bend = np.abs(np.gradient(self.samples[:, 3], s)) if len(s) > 2 else np.zeros(len(s))
        spin = math.radians(limits.rotation_acceleration)
        with np.errstate(divide='ignore'):
            cap = np.minimum(top_speed, math.radians(limits.path_rotation) / curvature) ** 2
            cap = np.minimum(cap, 0.5 * spin / bend)
            self._ease = (0.4 * spin / curvature).tolist()
        v2, ease, steps = cap.tolist(), self._ease, np.diff(s).tolist()
        v2[-1] = 0.0
        brake = limits.goal_deceleration if final else limits.deceleration
        for i in range(len(steps) - 1, -1, -1):
            v2[i] = min(v2[i], v2[i + 1] + 2.0 * min(brake, ease[i], ease[i + 1]) * steps[i])
        self.entry_fits = entry_speed ** 2 <= v2[0] + 1.0
        fastest_entry = entry_speed ** 2 - 2.0 * limits.deceleration * s
        return np.maximum(v2, fastest_entry).tolist()

    def _segment(self, s: float) -> Tuple[int, float]:
        i = min(max(bisect.bisect_right(self._s, s) - 1, 0), len(self._s) - 2)
        return i, (s - self._s[i]) / (self._s[i + 1] - self._s[i])

    def speed_at(self, s: float) -> float:
        """Returns the highest speed (mm/s) allowed at arc length `s` (mm)."""
        if s >= self.length:
            return 0.0
        i, u = self._segment(s)
        return math.sqrt(max(self._v2[i] * (1 - u) + self._v2[i + 1] * u, 0.0))

    def acceleration_at(self, s: float) -> float:
        """Returns the highest acceleration (mm/s2) that the rotation can follow at arc length
        `s`.
        """
        i, _ = self._segment(s)
        return min(self._ease[i], self._ease[i + 1])

    def pose_at(self, s: float) -> SimPose:
        """Returns the robot's pose at arc length `s`."""
        i, u = self._segment(min(max(s, 0.0), self.length))
        a, b = self._rows[i], self._rows[i + 1]
        # heading between two samples: cubic in u would be exact; linear is within 0.01 deg
        direction = math.degrees(a[2] * (1 - u) + b[2] * u)
        return SimPose(a[0] * (1 - u) + b[0] * u, a[1] * (1 - u) + b[1] * u,
                       normalise(direction + 180.0 if self.reverse else direction))

    def curvature_at(self, s: float) -> float:
        """Returns the signed curvature (1/mm) at arc length `s`."""
        i, u = self._segment(s)
        return self._rows[i][3] * (1 - u) + self._rows[i + 1][3] * u

    def cut(self, start: float, end: float) -> np.ndarray:
        """Returns the samples between two arc lengths, with new samples at both ends."""
        inner = [row for s, row in zip(self._s, self._rows) if start + 1.0 < s < end - 1.0]
        return np.array([self._row_at(start), *inner, self._row_at(end)])

    def _row_at(self, s: float) -> List[float]:
        i, u = self._segment(s)
        return [p * (1 - u) + q * u for p, q in zip(self._rows[i], self._rows[i + 1])]


Manoeuvre = Union[Turn, SmoothTrack]


def straight(pose: SimPose, distance: float) -> np.ndarray:
    """Returns samples of a straight of `distance` mm from `pose`; backwards if negative."""
    direction = pose.theta if distance >= 0 else pose.theta + 180.0
    return line(np.array([pose.x, pose.y]), np.array([pose.ahead(distance).x,
                                                       pose.ahead(distance).y]),
                 math.radians(direction))


def straight_track(pose: SimPose, distance: float, limits: Limits = LD90_LIMITS,
                   top_speed: Optional[float] = None) -> SmoothTrack:
    """Returns a straight drive of `distance` mm; backwards if negative."""
    fastest = limits.speed if distance >= 0 else limits.reverse_speed
    return SmoothTrack(straight(pose, distance), limits, reverse=distance < 0,
                       top_speed=min(fastest, top_speed or fastest))


def line(a: np.ndarray, b: np.ndarray, direction: float) -> np.ndarray:
    """Returns samples of the straight from a to b, which has the direction `direction` (rad)."""
    count = int(np.hypot(*(b - a)) / STRAIGHT_STEP) + 2
    xy = a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)
    return np.column_stack([xy, np.full(count, direction), np.zeros(count)])
