"""Fences that keep a robot in the corridors of its graph: few rectangles or lines. mm, map frame.

How few are found: a *guard line* runs around the floor, just outside it. Nothing leaves the floor
when every point of the guard line has a wall or a fence within the robot's half width, so that is
what is covered, as a set cover. We walk along the guard line; at the first point that nothing
covers yet, rectangles of several directions and distances are grown from there until they would
touch the floor, and the one that covers most of what is still open stays. Grown to the other side
of a block between corridors, one rectangle covers the block's whole guard line.
"""
from __future__ import annotations

from typing import Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from scipy.spatial import cKDTree
from shapely.geometry import LinearRing, Polygon, box
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from omron_ld90.graph.corridors import MITRE, ROBOT_HALF_WIDTH
from omron_ld90.maps.geometry import RotatedRectangle

GUARD = 15.0  # mm, from the floor to the guard line
STEP = 40.0  # mm, between the points that stand for the guard line
REACH = ROBOT_HALF_WIDTH - STEP / 2 - 10.0
"""A point of the guard line is covered by what is this near (mm): between two covered points a
robot as wide as it is cannot pass, with 10 mm to spare."""
CLEARANCE = 2.0  # mm, between fence and floor: more than the rounding to whole mm
LONGEST = 10000.0  # mm, side of a fence: what a person still sees at once in an editor
THICKNESS = 200.0  # mm, of a fence along a corridor
NARROW = 40.0  # mm, of one that ends in a sharp corner
INSET = 1.0  # mm, by which the sides of a fence may be touched
DIGITS = 6  # of degrees, in a map file
POST = 18.0  # mm, side of the square that fits anywhere on the guard line
OFFSETS = (CLEARANCE - GUARD, 20.0, 60.0, 100.0, 140.0, 180.0)
"""Distances (mm) from the guard line, away from the floor, at which a fence may begin."""
LOOK_AHEAD = (250.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0, 2600.0, 3200.0)
"""Arc lengths (mm) along the guard line to which a fence may be parallel, where it is curved."""
SAME_DIRECTION = float(np.cos(np.radians(0.5)))
STRAIGHT = 500.0  # mm of the guard line in one direction that a fence follows
STAND_OFF = 0.02  # points that a fence must cover more for every mm it stands off the floor
LONGEST_GAP = 1000.0  # mm along a fence without anything to cover: beyond it ends
WORTH = 1.5  # times the points that a fence across a whole block must cover to be worth its area


class Fence(NamedTuple):
    """A rectangle along the axes of a frame: `left..right` along it, `near..far` across (mm)."""

    frame: Frame
    left: float
    right: float
    near: float
    far: float

    def covers(self, points: np.ndarray) -> np.ndarray:
        """Which of the points (N,2), in the fence's frame, are within REACH."""
        u, v = points[:, 0], points[:, 1]
        beside = np.maximum(np.maximum(self.left - u, u - self.right), 0.0)
        before = np.maximum(np.maximum(self.near - v, v - self.far), 0.0)
        return beside ** 2 + before ** 2 <= REACH ** 2

    def trimmed(self, points: np.ndarray) -> Fence:
        """No longer and no deeper than needed for those of `points` (N,2) that it covers.

        It ends on either side of the frame's origin where a long gap begins.
        """
        covered = points[self.covers(points)]
        if not len(covered):
            return self
        along = np.sort(np.append(np.clip(covered[:, 0], self.left, self.right), 0.0))
        gaps = np.flatnonzero(np.diff(along) > LONGEST_GAP)
        origin = np.searchsorted(along, 0.0)
        left = along[gaps[gaps < origin].max(initial=-1) + 1]
        right = along[gaps[gaps >= origin].min(initial=len(along) - 1)]
        if right - left < POST:
            left, right = max(self.left, left - POST / 2), min(self.right, right + POST / 2)
        least = min(self.far, self.near + THICKNESS)
        return self._replace(left=float(left), right=float(right),
                             far=max(least, min(self.far, float(covered[:, 1].max()))))

    @property
    def rectangle(self) -> RotatedRectangle:
        """The same in the map frame, turned by as little as describes it."""
        middle = self.frame.to_map(np.array(((self.left + self.right) / 2.0,
                                             (self.near + self.far) / 2.0)))
        width, height = self.right - self.left, self.far - self.near
        quarters = round(self.frame.degrees / 90.0)
        if quarters % 2:
            width, height = height, width
        yaw = round(self.frame.degrees - 90.0 * quarters, DIGITS)
        return RotatedRectangle(float(middle[0]), float(middle[1]), width, height, yaw)

    @property
    def line(self) -> Tuple[float, float, float, float]:
        """x1, y1, x2, y2 of the side that faces the floor, in the map frame."""
        ends = np.array(((self.left, self.near), (self.right, self.near)))
        return tuple(self.frame.to_map(ends).reshape(-1).tolist())


class Frame(NamedTuple):
    """A frame with its origin on the guard line: u along a direction, v away from the floor."""

    origin: np.ndarray
    direction: np.ndarray

    @property
    def _axes(self) -> np.ndarray:
        c, s = self.direction
        return np.array(((c, s), (-s, c)))

    @property
    def degrees(self) -> float:
        """Direction of u in the map frame."""
        return float(np.degrees(np.arctan2(self.direction[1], self.direction[0])))

    def of(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 2) of the map frame in this frame."""
        return (points - self.origin) @ self._axes.T

    def to_map(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 2) of this frame in the map frame."""
        return points @ self._axes + self.origin


def fence_areas(floor: BaseGeometry, walls: np.ndarray) -> List[Fence]:
    """Rectangles around `floor`, which must stay free, where `walls` (N,2) leave it open."""
    return _fences(floor, walls, THICKNESS)


def fence_lines(floor: BaseGeometry, walls: np.ndarray) -> List[Fence]:
    """The same as `fence_areas`, but nothing is deeper than a line."""
    return _fences(floor, walls, 0.0)


def _fences(floor: BaseGeometry, walls: np.ndarray, thickness: float) -> List[Fence]:
    nearest_wall = cKDTree(walls) if len(walls) else None
    fences: List[Fence] = []
    for yard, outlines in _yards(floor):
        fences += _Yard(yard, outlines, nearest_wall).fences(thickness)
    return fences


def _yards(floor: BaseGeometry) -> Iterator[Tuple[Polygon, List[np.ndarray]]]:
    """The connected pieces of what lies outside the guard line, with the guard line around each.

    The guard line has the yard at its left. Every version of GEOS gives the same: each makes the
    same shapes, but lists them in an order of its own.
    """
    everything = box(*floor.bounds).buffer(2.0 * LONGEST, join_style=MITRE)
    outside = everything.difference(floor.buffer(GUARD, join_style=MITRE))
    for piece in getattr(outside, 'geoms', [outside]):
        piece = orient(piece)
        outermost = piece.exterior.bounds == everything.bounds
        rings = list(piece.interiors) if outermost else [piece.exterior, *piece.interiors]
        yield piece, sorted((_outline(ring) for ring in rings), key=lambda line: tuple(line[0]))


def _outline(ring: LinearRing) -> np.ndarray:
    """The corners (N,2) of a ring, from the lowest of the leftmost around to it again."""
    corners = np.round(np.array(ring.coords)[:-1], 3)
    first = np.lexsort(corners.T[::-1])[0]
    around = np.roll(corners, -first, axis=0)
    return np.concatenate((around, around[:1]))


class _Yard:
    """A piece of what lies outside the floor, and the points of the guard line around it."""

    def __init__(self, yard: Polygon, outlines: Sequence[np.ndarray],
                 nearest_wall: Optional[cKDTree]) -> None:
        rings = [_resampled(outline) for outline in outlines]
        self._points = np.concatenate([points for points, _ in rings])
        self._directions = np.concatenate([directions for _, directions in rings])
        ends = np.cumsum([len(points) for points, _ in rings])
        self._rings = [np.arange(end - len(points), end)
                       for end, (points, _) in zip(ends, rings)]
        self._open = np.ones(len(self._points), bool)
        if nearest_wall is not None:
            distances, _ = nearest_wall.query(self._points, distance_upper_bound=REACH)
            self._open = np.isinf(distances)
        self._edges = _edges(yard.buffer(GUARD - CLEARANCE / 2, join_style=MITRE))
        self._index = _Neighbourhood(self._points, self._edges)

    def fences(self, thickness: float) -> List[Fence]:
        """Fences that cover all of the guard line that is open."""
        found: List[Fence] = []
        covered: List[np.ndarray] = []
        for ring, position in self._walk():
            if not self._open[ring[position]]:
                continue
            points, edges = self._index.around(self._points[ring[position]])
            fence = self._best(ring, position, points[self._open[points]], edges, thickness)
            found.append(fence)
            covered.append(points[fence.covers(fence.frame.of(self._points[points]))])
            self._open[covered[-1]] = False
        return _needed(found, covered)

    def _walk(self) -> Iterator[Tuple[np.ndarray, int]]:
        """Where fences are grown: first from the middle of long straight sides, then all around."""
        sides = [(len(side), number, side) for number, ring in enumerate(self._rings)
                 for side in _sides(self._directions[ring]) if len(side) * STEP >= STRAIGHT]
        for _, number, side in sorted(sides, key=lambda item: -item[0]):
            for position in sorted(range(len(side)), key=lambda at: abs(2 * at - len(side))):
                yield self._rings[number], side[position]
        for ring in self._rings:
            for position in range(len(ring)):
                yield ring, position

    def _best(self, ring: np.ndarray, position: int, open_points: np.ndarray, edges: np.ndarray,
              thickness: float) -> Fence:
        """The fence over a point of a ring that covers the most open points."""
        origin = self._points[ring[position]]
        directions, straight = self._directions_ahead(ring, position)
        offers = [_Offers(Frame(origin, direction), self._points[open_points], edges)
                  for direction in directions]
        for depth in (thickness, min(thickness, NARROW)):
            found = [(offer.worth(fence), index, fence) for index, offer in enumerate(offers)
                     for fence in offer.along_the_floor(depth)]
            if found:
                _, index, best = max(found, key=lambda item: item[0])
                return offers[index].deepened(best) if straight and thickness else best
        return _post(Frame(origin, directions[0]))

    def _directions_ahead(self, ring: np.ndarray, position: int) -> Tuple[np.ndarray, bool]:
        """The directions that a fence may take, and whether the guard line is straight here."""
        here = self._directions[ring[position]]
        soon = self._directions[ring[(position + int(STRAIGHT / STEP)) % len(ring)]]
        if here @ soon > SAME_DIRECTION:
            return here[None], True
        ahead = [(position + int(arc / STEP)) % len(ring) for arc in LOOK_AHEAD]
        chords = self._points[ring[ahead]] - self._points[ring[position]]
        lengths = np.hypot(*chords.T)
        chords = chords[lengths > STEP] / lengths[lengths > STEP, None]
        return np.concatenate((here[None], chords)), False


class _Offers:
    """The fences that one frame has to offer."""

    def __init__(self, frame: Frame, open_points: np.ndarray, edges: np.ndarray) -> None:
        self._frame = frame
        self._points = frame.of(open_points)
        self._edges = frame.of(edges)

    def along_the_floor(self, depth: float) -> Iterator[Fence]:
        """The longest fences over the frame's origin at several distances from the floor."""
        ahead = _first_beyond(self._edges, 0.0, 0.0, 0.0)
        for near in OFFSETS:
            span = _free_span(self._edges, near, near + depth) if near + depth < ahead else None
            if span is not None:
                yield Fence(self._frame, *span, near, near + depth).trimmed(self._points)

    def worth(self, fence: Fence) -> float:
        """How many points it covers; less for a fence that stands off the floor."""
        return fence.covers(self._points).sum() - STAND_OFF * fence.near

    def deepened(self, fence: Fence) -> Fence:
        """The fence, or one that reaches to the floor's other side where that is worth it."""
        best, most = fence, fence.covers(self._points).sum() * WORTH
        left, right = _free_span(self._edges, fence.near, fence.far)
        for base in (fence, fence._replace(left=left, right=right)):
            far = _first_beyond(self._edges, base.left + INSET, base.right - INSET, base.far)
            deep = base._replace(far=min(far, base.near + LONGEST)).trimmed(self._points)
            covered = deep.covers(self._points).sum()
            if covered > most:
                best, most = self._drawn_near(deep), covered
        return best

    def _drawn_near(self, fence: Fence) -> Fence:
        """The fence, reaching to the floor in front of it where that is free all along."""
        span = _free_span(self._edges, OFFSETS[0], fence.far)
        if span is None or span[0] > fence.left or span[1] < fence.right:
            return fence
        return fence._replace(near=OFFSETS[0])


class _Neighbourhood:
    """Finds what lies within the reach of a fence that covers a given point."""

    FEW = 2000

    def __init__(self, points: np.ndarray, edges: np.ndarray) -> None:
        self._edges = edges
        self._all = np.arange(len(points))
        self._trees = None
        if len(points) > self.FEW:
            self._trees = cKDTree(points), cKDTree(edges.mean(axis=1))

    def around(self, point: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Indices of guard points, and edges (M,2,2), near `point`."""
        if self._trees is None:
            return self._all, self._edges
        points, edges = (tree.query_ball_point(point, 1.1 * LONGEST) for tree in self._trees)
        return np.sort(points), self._edges[edges]


def _post(frame: Frame) -> Fence:
    """What fits where nothing else does: no corner is as far as GUARD from the frame's origin."""
    return Fence(frame, -POST / 2, POST / 2, -POST / 2, POST / 2)


def _resampled(outline: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Points (N,2) at most STEP apart along a closed outline, and the unit direction at each."""
    steps = np.diff(outline, axis=0)
    lengths = np.hypot(*steps.T)
    arc = np.concatenate(([0.0], np.cumsum(lengths)))
    at = np.linspace(0.0, arc[-1], int(np.ceil(arc[-1] / STEP)) + 1)[:-1]
    segment = np.searchsorted(arc, at, side='right') - 1
    directions = (steps / lengths[:, None])[segment]
    return outline[segment] + directions * (at - arc[segment])[:, None], directions


def _edges(area: Polygon) -> np.ndarray:
    """The outlines of an area as segments (M,2,2) of at most 1 m."""
    pieces = []
    for ring in [area.exterior, *area.interiors]:
        coordinates = np.array(ring.coords)
        for start, end in zip(coordinates, coordinates[1:]):
            count = max(1, int(np.ceil(np.hypot(*(end - start)) / 1000.0)))
            ends = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
            pieces.append(np.stack((ends[:-1], ends[1:]), axis=1))
    return np.concatenate(pieces)


def _sides(directions: np.ndarray) -> List[np.ndarray]:
    """The stretches of a ring without a change of direction, as positions in driving order."""
    turns = (directions * np.roll(directions, 1, axis=0)).sum(axis=1) < SAME_DIRECTION
    corners = np.flatnonzero(turns)
    if not len(corners):
        return [np.arange(len(directions))]
    around = np.roll(np.arange(len(directions)), -corners[0])
    return np.split(around, corners[1:] - corners[0])


def _free_span(edges: np.ndarray, near: float, far: float) -> Optional[Tuple[float, float]]:
    """How far (left, right) the strip near..far is free around u = 0; None if it is not there."""
    u, v = edges[..., 0], edges[..., 1]
    within = (v.min(axis=1) < far) & (v.max(axis=1) > near)
    low, high = _clipped(v[within], u[within], near, far)
    if np.any((low <= 0.0) & (high >= 0.0)):
        return None
    return high[high < 0.0].max(initial=-LONGEST), low[low > 0.0].min(initial=LONGEST)


def _first_beyond(edges: np.ndarray, left: float, right: float, beyond: float) -> float:
    """The smallest v that the edges in left..right have, of those that reach beyond `beyond`."""
    u, v = edges[..., 0], edges[..., 1]
    within = (u.min(axis=1) <= right) & (u.max(axis=1) >= left)
    low, high = _clipped(u[within], v[within], left, right)
    return float(low[high > beyond].min(initial=2.0 * LONGEST))


def _clipped(across: np.ndarray, along: np.ndarray, low: float,
             high: float) -> Tuple[np.ndarray, np.ndarray]:
    """Range of `along` (M,2) over the part of each segment where `across` is in low..high."""
    run = across[:, 1] - across[:, 0]
    flat = run == 0.0
    run = np.where(flat, 1.0, run)
    start = np.where(flat, 0.0, np.minimum(np.maximum((low - across[:, 0]) / run, 0.0), 1.0))
    end = np.where(flat, 1.0, np.minimum(np.maximum((high - across[:, 0]) / run, 0.0), 1.0))
    rise = along[:, 1] - along[:, 0]
    ends = along[:, :1] + np.stack((start, end), axis=1) * rise[:, None]
    return ends.min(axis=1), ends.max(axis=1)


def _needed(fences: Sequence[Fence], covered: Sequence[np.ndarray]) -> List[Fence]:
    """The fences without those whose points others cover as well; the smallest go first."""
    if not fences:
        return []
    times = np.bincount(np.concatenate(covered))
    kept = set(range(len(fences)))
    for index in sorted(kept, key=lambda index: len(covered[index])):
        if np.all(times[covered[index]] > 1):
            times[covered[index]] -= 1
            kept.discard(index)
    return [fences[index] for index in sorted(kept)]
