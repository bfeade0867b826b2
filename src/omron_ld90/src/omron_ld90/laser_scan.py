"""Computes the ranges that a laser measured. The input is the laser's hits in the map.

No ROS; metres, radians. ARCL sends the hits of a scan in the map frame: the robot has already
transformed them with its localization. The measured ranges follow from the hits and the pose of the
laser.
"""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omron_ld90 import robot_model

INCREMENT = math.radians(1.0)  # larger than the laser's own step, so that each beam has a hit
BEAMS = round(robot_model.LASER_FIELD_OF_VIEW / INCREMENT) + 1
FIRST_ANGLE = -robot_model.LASER_FIELD_OF_VIEW / 2.0
NEAREST = 0.02  # m


@dataclass(frozen=True)
class LaserPlace:
    """The pose of a laser in the map (m, rad)."""

    x: float
    y: float
    yaw: float


def ranges_of(hits: np.ndarray, laser: LaserPlace) -> np.ndarray:
    """Returns (BEAMS,) ranges from right to left: the distance of the nearest hit per direction.

    The range is infinite if there is no hit in a direction. Hits outside the field of view or the
    range are ignored.

    hits -- (N, 2), m, in the map
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
