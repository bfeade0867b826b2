"""The regions outside the floor, and the offset outline that must be covered. mm, map frame.

The outside of the floor consists of *outer regions*: one for every block between corridors, and one
that surrounds everything. The *offset outline* of a region is a line around it at the distance
OUTLINE_DISTANCE from the floor. If walls and fences cover all outlines, no robot can leave the
floor.
"""
from __future__ import annotations

from typing import Iterator, List, NamedTuple, Tuple

import numpy as np
from shapely.geometry import LinearRing, Polygon, box
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from omron_map_converter.corridors import MITRE

OUTLINE_DISTANCE = 15.0  # mm from the floor to the offset outline
STEP = 40.0  # mm between the points that represent the offset outline
CLEARANCE = 2.0  # mm between fence and floor; more than the error of rounding to mm
OUTSIDE = 30000.0  # mm; width of the examined margin around the floor
LONGEST_EDGE = 1000.0
SAME_DIRECTION = float(np.cos(np.radians(0.5)))


class OuterRegion(NamedTuple):
    """A connected region outside the floor; it is on the left of its offset outline."""

    points: np.ndarray
    """(N,2), at most STEP apart along the offset outline."""
    directions: np.ndarray
    """(N,2), the outline's unit direction at each point."""
    rings: List[np.ndarray]
    """For each closed part of the outline, the indices of its points in order."""
    edges: np.ndarray
    """(M,2,2), segments of at most LONGEST_EDGE that no fence may cross."""


def outer_regions(floor: BaseGeometry) -> Iterator[OuterRegion]:
    """Yields the regions outside `floor`: the one that surrounds it, and those that it encloses.

    The result is the same for every version of GEOS. All versions make the same shapes, but begin
    their lists of corners at different corners; this function puts them in a fixed order.
    """
    everything = box(*floor.bounds).buffer(OUTSIDE, join_style=MITRE)
    outside = everything.difference(floor.buffer(OUTLINE_DISTANCE, join_style=MITRE))
    for piece in getattr(outside, 'geoms', [outside]):
        piece = orient(piece)
        outermost = piece.exterior.bounds == everything.bounds
        rings = list(piece.interiors) if outermost else [piece.exterior, *piece.interiors]
        outlines = sorted((_outline(ring) for ring in rings), key=lambda line: tuple(line[0]))
        yield _region(piece, outlines)


def sides(directions: np.ndarray) -> List[np.ndarray]:
    """Returns the straight stretches of a ring, each as its positions on the ring, in order."""
    turns = (directions * np.roll(directions, 1, axis=0)).sum(axis=1) < SAME_DIRECTION
    corners = np.flatnonzero(turns)
    if not len(corners):
        return [np.arange(len(directions))]
    around = np.roll(np.arange(len(directions)), -corners[0])
    return np.split(around, corners[1:] - corners[0])


def _region(piece: Polygon, outlines: List[np.ndarray]) -> OuterRegion:
    points, directions = zip(*map(_resampled, outlines))
    ends = np.cumsum([len(ring) for ring in points])
    rings = [np.arange(end - len(ring), end) for end, ring in zip(ends, points)]
    return OuterRegion(np.concatenate(points), np.concatenate(directions), rings,
                _edges(piece.buffer(OUTLINE_DISTANCE - CLEARANCE / 2.0, join_style=MITRE)))


def _outline(ring: LinearRing) -> np.ndarray:
    """Returns the corners (N,2) of a closed ring. The lowest of the leftmost corners stands both at
    the beginning and at the end.

    Corners that are equal when rounded to micrometres are merged.
    """
    corners = np.round(np.array(ring.coords)[:-1], 3)
    corners = corners[np.any(corners != np.roll(corners, 1, axis=0), axis=1)]
    first = np.lexsort(corners.T[::-1])[0]
    around = np.roll(corners, -first, axis=0)
    return np.concatenate((around, around[:1]))


def _resampled(outline: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Returns points (N,2) at most STEP apart along a closed outline,
    and the unit direction at each.
    """
    steps = np.diff(outline, axis=0)
    lengths = np.hypot(*steps.T)
    arc = np.concatenate(([0.0], np.cumsum(lengths)))
    at = np.linspace(0.0, arc[-1], int(np.ceil(arc[-1] / STEP)) + 1)[:-1]
    segment = np.searchsorted(arc, at, side='right') - 1
    directions = (steps / lengths[:, None])[segment]
    return outline[segment] + directions * (at - arc[segment])[:, None], directions


def _edges(area: Polygon) -> np.ndarray:
    pieces = []
    for ring in [area.exterior, *area.interiors]:
        corners = np.array(ring.coords)
        for start, end in zip(corners, corners[1:]):
            count = max(1, int(np.ceil(np.hypot(*(end - start)) / LONGEST_EDGE)))
            ends = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
            pieces.append(np.stack((ends[:-1], ends[1:]), axis=1))
    return np.concatenate(pieces)
