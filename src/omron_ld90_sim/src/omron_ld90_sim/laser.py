"""The safety laser: what it hits from a pose, in the map frame, as ARCL reports it.

Rays march over the floor's distance field in steps as long as the nearest wall allows (sphere
tracing), all rays at once. The facts give 240 degrees and 15 m; 455 rays is what a public driver
reserves for one scan. The place of the laser on the robot is not in the facts: it is taken to be
the turning centre.
"""
from __future__ import annotations

from typing import Sequence

import numpy as np

from omron_ld90_sim.floor import Floor
from omron_ld90_sim.kinematics import Pose

FIELD_OF_VIEW = 240.0   # deg
RANGE = 15000.0         # mm
RAYS = 455
_ANGLES = np.radians(np.linspace(-FIELD_OF_VIEW / 2, FIELD_OF_VIEW / 2, RAYS))


def scan(floor: Floor, pose: Pose, others: Sequence[np.ndarray] = ()) -> np.ndarray:
    """Ranges (mm) of the 455 rays from right to left; inf where nothing is within 15 m.

    `others` are the corners (N, 2) of what else stands there, each in order around it.
    """
    angles = _ANGLES + np.radians(pose.theta)
    direction = np.column_stack([np.cos(angles), np.sin(angles)])
    ranges = _march(floor, np.array([pose.x, pose.y]), direction)
    if others:
        starts = np.concatenate(others)
        ends = np.concatenate([np.roll(corners, -1, axis=0) for corners in others])
        ranges = np.minimum(ranges, _edges(starts - [pose.x, pose.y], ends - starts, direction))
    return ranges


def points(pose: Pose, ranges: np.ndarray) -> np.ndarray:
    """Hits (N, 2) in mm, map frame, for ranges measured at `pose`."""
    hit = np.isfinite(ranges)
    angles = _ANGLES[hit] + np.radians(pose.theta)
    return np.array([pose.x, pose.y]) + ranges[hit, None] * np.column_stack([np.cos(angles),
                                                                            np.sin(angles)])


def _march(floor: Floor, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    field, cell = floor.sight, floor.resolution
    rows, columns = field.shape
    start = (origin - floor.origin) / cell
    step = direction.T
    travelled = np.zeros(len(direction))
    ranges = np.full(len(direction), np.inf)
    active = np.arange(len(direction))
    limit = RANGE / cell
    while len(active):
        column = np.rint(start[0] + travelled[active] * step[0, active]).astype(int)
        row = np.rint(start[1] + travelled[active] * step[1, active]).astype(int)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        inside &= travelled[active] <= limit
        active, row, column = active[inside], row[inside], column[inside]
        free = field[row, column] / cell
        hit = free < 0.5
        ranges[active[hit]] = travelled[active[hit]] * cell
        # a cell's centre may be 0.71 cells nearer to the wall than the place of the ray in it
        travelled[active] += np.maximum(free - 0.75, 0.5)
        active = active[~hit]
    return ranges


def _edges(start: np.ndarray, along: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Ranges to the nearest of edges (E, 2) seen from the origin; inf where a ray misses all."""
    start, along = start[:, None, :], along[:, None, :]
    across = direction[:, 0] * along[..., 1] - direction[:, 1] * along[..., 0]
    with np.errstate(divide='ignore', invalid='ignore'):
        distance = (start[..., 0] * along[..., 1] - start[..., 1] * along[..., 0]) / across
        part = (start[..., 0] * direction[:, 1] - start[..., 1] * direction[:, 0]) / across
    hit = (distance >= 0) & (distance <= RANGE) & (part >= 0) & (part <= 1)
    return np.where(hit, distance, np.inf).min(axis=0)
