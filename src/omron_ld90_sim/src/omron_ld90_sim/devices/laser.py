"""The safety laser: its hits from a pose, in the map frame, in the form of ARCL.

All rays march at once over the floor's distance field, in steps as long as the distance to the
nearest wall (sphere tracing). The data sheet gives 240 degrees and 15 m. A public driver reserves
455 rays for one scan. The position of the laser on the robot is not known; it is assumed to be the
turning centre.
"""
from __future__ import annotations

from typing import Sequence

import numpy as np

from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose

FIELD_OF_VIEW = 240.0   # deg
RANGE = 15000.0         # mm
RAYS = 455
STEPS_AT_ONCE = 8       # steps of a ray between two checks for rays that have ended
_ANGLES = np.radians(np.linspace(-FIELD_OF_VIEW / 2, FIELD_OF_VIEW / 2, RAYS))


def scan(floor: SimFloor, pose: SimPose, others: Sequence[np.ndarray] = ()) -> np.ndarray:
    """Returns the ranges (mm) of the 455 rays from right to left; inf: no hit within 15 m.

    `others`: outlines of further obstacles, as arrays (K, N, 2) of K obstacles with N corners each,
    counter-clockwise.
    """
    angles = _ANGLES + np.radians(pose.theta)
    direction = np.column_stack([np.cos(angles), np.sin(angles)])
    ranges = _march(floor, np.array([pose.x, pose.y]), direction)
    for outlines in others:
        starts = outlines.reshape(-1, 2)
        along = np.roll(outlines, -1, axis=1).reshape(-1, 2) - starts
        ranges = np.minimum(ranges, _edges(starts - [pose.x, pose.y], along, direction))
    return ranges


def points(pose: SimPose, ranges: np.ndarray) -> np.ndarray:
    """Returns the hits (N, 2) in mm, map frame, for ranges measured at `pose`."""
    hit = np.isfinite(ranges)
    angles = _ANGLES[hit] + np.radians(pose.theta)
    return np.array([pose.x, pose.y]) + ranges[hit, None] * np.column_stack([np.cos(angles),
                                                                            np.sin(angles)])


def _march(floor: SimFloor, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    field, cell = floor.sight.ravel(), floor.resolution
    rows, columns = floor.sight.shape
    ranges = np.full(len(direction), np.inf)
    start = (origin - floor.origin) / cell + 0.5        # in cells; a cell's edges are whole numbers
    along = direction.T / cell                          # cells per mm
    edge = np.where(along > 0, [[columns], [rows]], 0.0) - start[:, None]
    with np.errstate(divide='ignore', invalid='ignore'):    # mm until a ray leaves the map
        sides = np.where(along == 0, np.inf, edge / along)
    limit = np.minimum(sides.min(axis=0), RANGE)
    rays: np.ndarray = np.arange(len(direction))
    travelled: np.ndarray = np.zeros(len(direction))
    while len(rays):
        for _ in range(STEPS_AT_ONCE):
            x, y = start[0] + travelled * along[0], start[1] + travelled * along[1]
            free = field.take(y.astype(int) * columns + x.astype(int), mode='clip')
            # `free` holds for the centre of the cell; the ray may be 0.71 cells nearer to the wall
            step = np.maximum(free - 0.75 * cell, 0.5 * cell)
            travelled += np.where(free < 0.5 * cell, 0.0, step)
        on_map = travelled < limit
        going = free >= 0.5 * cell
        hit = on_map & ~going
        ranges[rays[hit]] = travelled[hit]
        going &= on_map
        rays, travelled = rays[going], travelled[going]
        along, limit = along[:, going], limit[going]
    return ranges


def _edges(start: np.ndarray, along: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Returns the range at which each ray from the origin first hits an edge; inf: it hits none.

    An edge (E, 2) counts only if its outer side faces the origin.
    """
    beside = start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]
    seen = beside < 0
    start, along, beside = start[seen, None, :], along[seen, None, :], beside[seen, None]
    if not len(start):
        return np.full(len(direction), np.inf)
    with np.errstate(divide='ignore', invalid='ignore'):
        across = direction[:, 0] * along[..., 1] - direction[:, 1] * along[..., 0]
        distance = beside / across
        part = (start[..., 0] * direction[:, 1] - start[..., 1] * direction[:, 0]) / across
    hit = (distance >= 0) & (distance <= RANGE) & (part >= 0) & (part <= 1)
    return np.where(hit, distance, np.inf).min(axis=0)
