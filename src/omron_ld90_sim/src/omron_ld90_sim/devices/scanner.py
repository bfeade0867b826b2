"""The laser as a device: noisy scans, and the kept points of recent scans."""
from __future__ import annotations

from collections import deque
from typing import Deque, Sequence, Tuple

import numpy as np

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.devices import laser
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_ld90_sim.motion.noise import noise

NOISE = 6.0             # mm, standard deviation along the ray
KEPT_FOR = 30.0         # s for which cumulative points are kept
KEPT_WITHIN = 4000.0    # mm; kept points within this distance of the robot are reported
KEPT_POINTS = 200       # largest number of points in a report


class Scanner:
    """The range device `Laser_1`."""

    def __init__(self, clock: SimClock, seed: int) -> None:
        self._clock, self._seed = clock, seed
        self._kept: Deque[Tuple[float, np.ndarray]] = deque()

    def scan(self, floor: SimFloor, true: SimPose, believed: SimPose,
             others: Sequence[np.ndarray]) -> np.ndarray:
        """Returns the hits (N, 2) of a scan at `true`, drawn as if at `believed`; mm, map frame."""
        ranges = laser.scan(floor, true, others)
        ranges = ranges + noise(self._seed, self._clock.now, NOISE, len(ranges))
        hits = laser.points(believed, ranges)
        self._kept.append((self._clock.now, hits))
        while self._kept[0][0] < self._clock.now - KEPT_FOR:
            self._kept.popleft()
        return hits

    def cumulative(self, around: SimPose) -> np.ndarray:
        """Returns the points (N, 2) near `around` that were seen recently."""
        seen = np.concatenate([hits for _, hits in self._kept])
        near = np.hypot(*(seen - [around.x, around.y]).T) <= KEPT_WITHIN
        return seen[near][-KEPT_POINTS:]
