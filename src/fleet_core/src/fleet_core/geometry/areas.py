"""Areas: the parts of the floor where a robot may be, beside the places of the graph."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np

from fleet_core.geometry.capsules import time_within

Point = Tuple[float, float]
"""x, y in m, in the graph's frame."""


@dataclass(frozen=True)
class Area:
    """All points within `radius` (m) of the line through the points `line`, or of a single point.
    """

    line: Tuple[Point, ...]
    radius: float = 0.0


def are_nearer(one: Sequence[Point], other: Sequence[Point], distance: float) -> bool:
    """Returns whether two lines through points come nearer to each other than `distance` (m)."""
    if len(one) == len(other) == 1:  # for example two robots that stand between vertices
        return math.dist(one[0], other[0]) <= distance
    (first, last), others = _segments(one), np.stack(_segments(other), axis=2)
    for segment in range(others.shape[1]):
        start, end = (np.broadcast_to(others[:, segment, which, None], first.shape)
                      for which in (0, 1))
        entry, exit = time_within(first, last, start, end, np.full(first.shape[1], distance))
        if np.any(entry <= exit):
            return True
    return False


def _segments(line: Sequence[Point]) -> Tuple[np.ndarray, np.ndarray]:
    """Returns the first points (2,N) and the last points (2,N) of a line's segments.

    A single point is one segment.
    """
    points = np.array(line, dtype=float).T
    return (points, points) if len(line) == 1 else (points[:, :-1], points[:, 1:])
