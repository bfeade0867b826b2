"""Ranges by angle, as a laser measures them, from hits in the map. No ROS; metres, radians.

ARCL gives a scan's hits in the map frame, already put there by the robot's localisation. What a
range finder measured is found by looking at them from where the laser was.
"""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omron_ld90 import robot_model

INCREMENT = math.radians(1.0)  # wider than the laser's own step, so that no beam falls between
BEAMS = round(robot_model.LASER_FIELD_OF_VIEW / INCREMENT) + 1
FIRST_ANGLE = -robot_model.LASER_FIELD_OF_VIEW / 2.0
NEAREST = 0.02  # m


@dataclass(frozen=True)
class LaserPlace:
    """Where a laser is, and which way it looks, in the map (m, rad)."""

    x: float
    y: float
    yaw: float


def ranges_of(hits: np.ndarray, laser: LaserPlace) -> np.ndarray:
    """(BEAMS,) ranges from right to left: the nearest of the `hits` (N, 2) in each direction.

    Infinite where there is none. Hits outside the field of view or the range are left out.
    """
    right, up = (np.asarray(hits, float).reshape(-1, 2) - (laser.x, laser.y)).T
    distances = np.hypot(right, up)
    angles = np.arctan2(up, right) - laser.yaw
    angles = (angles + math.pi) % (2.0 * math.pi) - math.pi
    beams = np.rint((angles - FIRST_ANGLE) / INCREMENT).astype(int)
    seen = ((beams >= 0) & (beams < BEAMS) & (distances >= NEAREST)
            & (distances <= robot_model.LASER_RANGE))
    ranges = np.full(BEAMS, np.inf)
    np.minimum.at(ranges, beams[seen], distances[seen])
    return ranges
