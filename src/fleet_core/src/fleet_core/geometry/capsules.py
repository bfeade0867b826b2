"""The part of a straight line whose points are nearer than a distance to a line segment.

All points nearer than r to a line segment form a *capsule*: a rectangle with a half disc at each
end. A capsule is convex. So a point on a straight path is in it during one interval, or never.
"""
from __future__ import annotations

from typing import Tuple

import numpy as np


def time_within(start: np.ndarray, end: np.ndarray, first: np.ndarray, last: np.ndarray,
                distance: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Returns the times at which points are in capsules. Each point moves from `start` to `end`;
    its capsule reaches from `first` to `last`.

    All are (2,N) in m, `distance` is (N,). Time runs from 0 to 1. Returns entries and exits (N,).
    If the entry is greater than the exit, the point is never nearer than the distance.
    """
    path = end - start
    entry, exit = np.full(path.shape[1], np.inf), np.full(path.shape[1], -np.inf)
    for part in (_within_disc(start - first, path, distance),
                 _within_disc(start - last, path, distance),
                 _within_rectangle(start - first, path, last - first, distance)):
        low, high = np.maximum(part[0], 0.0), np.minimum(part[1], 1.0)
        # If a point enters a part only at the very end, or leaves it at the very beginning, the
        # part does not count.
        absent = (part[0] >= part[1]) | (part[0] >= 1.0) | (part[1] <= 0.0)
        low[absent], high[absent] = np.inf, -np.inf
        entry, exit = np.minimum(entry, low), np.maximum(exit, high)
    return entry, exit


def _within_disc(offset: np.ndarray, path: np.ndarray,
                 radius: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Returns the two times between which a moving point is within `radius` of the origin.

    At time t the point is at `offset` + t * `path`. If the two times are equal, the point never
    comes nearer than `radius`.
    """
    square = path[0] * path[0] + path[1] * path[1]
    half = offset[0] * path[0] + offset[1] * path[1]
    rest = offset[0] * offset[0] + offset[1] * offset[1] - radius * radius
    still = square == 0.0
    square[still] = 1.0
    width = np.sqrt(np.maximum(half * half - square * rest, 0.0))
    low, high = (-half - width) / square, (-half + width) / square
    if still.any():
        low[still], high[still] = np.where(rest[still] < 0.0, -np.inf, 0.0), \
            np.where(rest[still] < 0.0, np.inf, 0.0)
    return low, high


def _within_rectangle(offset: np.ndarray, path: np.ndarray, axis: np.ndarray,
                      width: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Returns the two times between which a moving point is in a rectangle.

    At time t the point is at `offset` + t * `path`.
    The rectangle reaches from 0 along the whole `axis`, and by `width` to either side of the axis.
    """
    length = np.hypot(axis[0], axis[1])
    unit = axis / np.where(length > 0.0, length, 1.0)
    along, along_path = _along(offset, unit), _along(path, unit)
    across, across_path = _across(offset, unit), _across(path, unit)
    low, high = _within(along, along_path, np.zeros_like(length), length)
    low2, high2 = _within(across, across_path, -width, width)
    return np.maximum(low, low2), np.minimum(high, high2)


def _along(vectors: np.ndarray, unit: np.ndarray) -> np.ndarray:
    return vectors[0] * unit[0] + vectors[1] * unit[1]


def _across(vectors: np.ndarray, unit: np.ndarray) -> np.ndarray:
    return vectors[1] * unit[0] - vectors[0] * unit[1]


def _within(at: np.ndarray, step: np.ndarray, least: np.ndarray,
            most: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Returns the two times between which a moving coordinate is between `least` and `most`.

    At time t the coordinate is `at` + t * `step`. (inf, -inf): it is never strictly between them.
    """
    still = step == 0.0
    safe = np.where(still, 1.0, step)
    with np.errstate(over='ignore'):  # division by a step near 0 gives infinity, which is right
        one, other = (least - at) / safe, (most - at) / safe
    low, high = np.minimum(one, other), np.maximum(one, other)
    if still.any():
        within = (at[still] > least[still]) & (at[still] < most[still])
        low[still] = np.where(within, -np.inf, np.inf)
        high[still] = np.where(within, np.inf, -np.inf)
    return low, high
