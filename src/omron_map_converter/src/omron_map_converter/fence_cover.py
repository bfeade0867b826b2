"""Makes fences: few rectangles or lines that keep a robot in the corridors of its graph.

Lengths are in mm, in the map frame.

The fences are complete when every point of the offset outline around the floor has a wall or a
fence within the robot's half width. To find few fences is a set cover problem; the search is
greedy. It walks along the outline. At each point that is not covered, it grows rectangles of
several directions and distances until they would touch the floor. It keeps the rectangle that
covers the largest number of open points. A rectangle that grows to the other side of a block
between corridors covers the block's whole outline.
"""
from __future__ import annotations

from typing import Iterator, List, Optional, Sequence, Tuple

import numpy as np
from scipy.spatial import cKDTree
from shapely.geometry.base import BaseGeometry

from omron_map_converter.fence_shapes import (
    LONGEST,
    REACH,
    SHORTEST,
    THICKNESS,
    Fence,
    Frame,
    first_beyond,
    free_span,
)
from omron_map_converter.outer_regions import (
    CLEARANCE,
    LONGEST_EDGE,
    OUTLINE_DISTANCE,
    SAME_DIRECTION,
    STEP,
    OuterRegion,
    outer_regions,
    sides,
)

NARROW = 40.0  # depth of a fence at a sharp corner
OFFSETS = (CLEARANCE - OUTLINE_DISTANCE, 20.0, 60.0, 100.0, 140.0, 180.0)
"""Distances from the outline, away from the floor, at which a fence may begin."""
LOOK_AHEAD = (250.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0, 2600.0, 3200.0)
"""Arc lengths along a curved outline; a fence may be parallel to the chord of such an arc."""
STRAIGHT = 500.0  # length of the outline in one direction that a fence follows
STAND_OFF = 0.02  # additional points that a fence must cover per mm of distance from the floor
WORTH = 1.5  # a fence across a whole block must cover this many times the points of a shallow one
INSET = 1.0  # edges this near to either end of a fence do not limit its growth in depth
MANY = 2000  # if there are more outline points than this, only near points are examined
NEARBY = 1.5 * LONGEST + LONGEST_EDGE


def fence_areas(floor: BaseGeometry, walls: np.ndarray) -> List[Fence]:
    """Returns rectangles around `floor`, which must stay free,
    at openings between `walls` (N,2).
    """
    return _fences(floor, walls, THICKNESS)


def fence_lines(floor: BaseGeometry, walls: np.ndarray) -> List[Fence]:
    """Returns fences like `fence_areas`, but without depth, for use as lines."""
    return _fences(floor, walls, 0.0)


def _fences(floor: BaseGeometry, walls: np.ndarray, thickness: float) -> List[Fence]:
    nearest_wall = cKDTree(walls) if len(walls) else None
    return [fence for region in outer_regions(floor)
            for fence in _Cover(region, nearest_wall, thickness).fences()]


class _Cover:
    """Covers the offset outline of one outer region."""

    def __init__(self, region: OuterRegion, nearest_wall: Optional[cKDTree],
                 thickness: float) -> None:
        self._region = region
        self._thickness = thickness
        self._open = np.ones(len(region.points), bool)
        if nearest_wall is not None:
            distances, _ = nearest_wall.query(region.points, distance_upper_bound=REACH)
            self._open = np.isinf(distances)
        self._trees = None
        if len(region.points) > MANY:
            self._trees = cKDTree(region.points), cKDTree(region.edges.mean(axis=1))

    def fences(self) -> List[Fence]:
        """Returns fences that cover all open parts of the outline."""
        found: List[Fence] = []
        covered: List[np.ndarray] = []
        for ring, position in self._walk():
            index = ring[position]
            if self._open[index]:
                points, edges = self._around(self._region.points[index])
                fence = self._best(ring, position, points[self._open[points]], edges)
                found.append(fence)
                covered.append(points[fence.covers(fence.frame.of(self._region.points[points]))])
                self._open[covered[-1]] = False
        return _needed(found, covered)

    def _walk(self) -> Iterator[Tuple[np.ndarray, int]]:
        """Yields the places at which fences are grown, as pairs of a ring and a position on it.

        The first places are in the middle of long straight sides; then the whole outline follows.
        """
        straight = [(len(side), number, side) for number, ring in enumerate(self._region.rings)
                    for side in sides(self._region.directions[ring])
                    if len(side) * STEP >= STRAIGHT]
        for length, number, side in sorted(straight, key=lambda item: -item[0]):
            for at in sorted(range(length), key=lambda at: abs(2 * at - length)):
                yield self._region.rings[number], int(side[at])
        for ring in self._region.rings:
            for position in range(len(ring)):
                yield ring, position

    def _around(self, point: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Returns what a fence at `point` can reach: indices of outline points, and edges (M,2,2).
        """
        if self._trees is None:
            return np.arange(len(self._region.points)), self._region.edges
        points, edges = (tree.query_ball_point(point, NEARBY) for tree in self._trees)
        return np.sort(points), self._region.edges[edges]

    def _best(self, ring: np.ndarray, position: int, open_points: np.ndarray,
              edges: np.ndarray) -> Fence:
        """Returns the fence with the greatest worth at a point of a ring, deepened if possible."""
        origin = self._region.points[ring[position]]
        directions, straight = self._directions_ahead(ring, position)
        offers = [_Offers(Frame(origin, direction), self._region.points[open_points], edges)
                  for direction in directions]
        for depth in (self._thickness, min(self._thickness, NARROW)):
            found = [(offer.worth(fence), index, fence) for index, offer in enumerate(offers)
                     for fence in offer.along_the_floor(depth)]
            if found:
                _, index, best = max(found, key=lambda item: item[0])
                return offers[index].deepened(best) if straight and depth else best
        return _post(Frame(origin, directions[0]))

    def _directions_ahead(self, ring: np.ndarray, position: int) -> Tuple[np.ndarray, bool]:
        """Returns the possible directions of a fence, and whether the outline is straight here."""
        here = self._region.directions[ring[position]]
        soon = self._region.directions[ring[(position + int(STRAIGHT / STEP)) % len(ring)]]
        if here @ soon > SAME_DIRECTION:
            return here[None], True
        ahead = [(position + int(arc / STEP)) % len(ring) for arc in LOOK_AHEAD]
        chords = self._region.points[ring[ahead]] - self._region.points[ring[position]]
        lengths = np.hypot(*chords.T)
        chords = chords[lengths > STEP] / lengths[lengths > STEP, None]
        return np.concatenate((here[None], chords)), False


class _Offers:
    """The possible fences in one frame."""

    def __init__(self, frame: Frame, open_points: np.ndarray, edges: np.ndarray) -> None:
        self._frame = frame
        self._points = frame.of(open_points)
        self._edges = frame.of(edges)

    def along_the_floor(self, depth: float) -> Iterator[Fence]:
        """Yields the longest fences at the frame's origin, at several distances from the floor."""
        ahead = first_beyond(self._edges, 0.0, 0.0, 0.0)
        for near in OFFSETS:
            span = free_span(self._edges, near, near + depth) if near + depth < ahead else None
            if span is not None:
                yield Fence(self._frame, *span, near, near + depth).trimmed(self._points)

    def worth(self, fence: Fence) -> float:
        """Returns the number of points that the fence covers, reduced by STAND_OFF for each mm
        between fence and floor.
        """
        return fence.covers(self._points).sum() - STAND_OFF * fence.near

    def deepened(self, fence: Fence) -> Fence:
        """Returns the fence, or a fence across the whole block if that covers enough points."""
        best, most = fence, fence.covers(self._points).sum() * WORTH
        span = free_span(self._edges, fence.near, fence.far)
        if span is None:
            return fence
        for base in (fence, fence._replace(left=span[0], right=span[1])):
            far = first_beyond(self._edges, base.left + INSET, base.right - INSET, base.far)
            deep = base._replace(far=min(far, base.near + LONGEST)).trimmed(self._points)
            covered = deep.covers(self._points).sum()
            if covered > most:
                best, most = self._drawn_near(deep), covered
        return best

    def _drawn_near(self, fence: Fence) -> Fence:
        """Returns the fence, extended up to the floor if the space between them is free."""
        span = free_span(self._edges, OFFSETS[0], fence.far)
        if span is None or span[0] > fence.left or span[1] < fence.right:
            return fence
        return fence._replace(near=OFFSETS[0])


def _post(frame: Frame) -> Fence:
    """Returns a fence so small that it fits at every point of the outline: none of its corners
    reaches the floor.
    """
    half = SHORTEST / 2.0
    return Fence(frame, -half, half, -half, half)


def _needed(fences: Sequence[Fence], covered: Sequence[np.ndarray]) -> List[Fence]:
    """Returns the fences that are left after needless fences are removed.

    A fence is needless if others cover all its points. The fence with the fewest points is removed
    first.
    """
    if not fences:
        return []
    times = np.bincount(np.concatenate(covered))
    kept = set(range(len(fences)))
    for index in sorted(kept, key=lambda index: len(covered[index])):
        if np.all(times[covered[index]] > 1):
            times[covered[index]] -= 1
            kept.discard(index)
    return [fences[index] for index in sorted(kept)]
