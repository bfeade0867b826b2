"""The progress of a robot along a route, computed from its locations.

Metres, map frame. The module uses only geometry and the order of the edges: no commands, no time.
"""
from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

from route_protocol.values import SymbolicPose
from trajectory_graph import Curve, Graph, Vertex

Point = Tuple[float, float]

SLACK = 0.5  # m; on a curve a robot can advance by this length plus twice its movement
MOST = 99.9  # per cent, the maximum on an edge that is not complete


class RouteProgress:
    """The current edge of a route and the position on it; both only move forward."""

    def __init__(self, graph: Graph, edges: Sequence[int], tolerance: float, by_word: Sequence[int],
                 place: Point, current: int = 0) -> None:
        """Begins on `edges[current]`, at the point of the edge that is nearest to `place`.

        tolerance -- m, distance to a vertex within which the robot passes the vertex
        by_word   -- vertices (the dock) that are passed only after the robot has reported it; see
                     `complete_current`
        """
        self.graph = graph
        self.edges = tuple(edges)
        self.tolerance = tolerance
        self.current = current
        """Index of the edge that is driven; len(edges) when the route is done."""
        self._by_word = frozenset(by_word)
        self._place = place
        self._arc = 0.0 if self.done else self._curve().project(*place).arc_length

    @property
    def done(self) -> bool:
        """Whether every edge is complete."""
        return self.current >= len(self.edges)

    @property
    def arc(self) -> float:
        """The arc length (m) that is reached on the current edge."""
        return self._arc

    @property
    def pose(self) -> SymbolicPose:
        """The position on the route. 100 % is reached only when the last edge is complete."""
        if self.done:
            return SymbolicPose(self.edges[-1], 100.0)
        fraction = self._arc / self._curve().length
        return SymbolicPose(self.edges[self.current], min(100.0 * fraction, MOST))

    @property
    def travelled(self) -> float:
        """Length (m) of the part of the route that was driven."""
        return self._lengths(0, self.current) + (0.0 if self.done else self._arc)

    @property
    def next_stop(self) -> int:
        """Index of the edge at whose end the robot must stop next: the next dock or the end."""
        for index in range(self.current, len(self.edges)):
            if self.end(index).id in self._by_word:
                return index
        return len(self.edges) - 1

    def end(self, index: int) -> Vertex:
        """Returns the vertex at the end of the edge with this index."""
        return self.graph.end_vertex(self.edges[index])

    def distance_to_end(self, index: int) -> float:
        """Returns the length (m) of the route from the robot to the end of the edge `index`."""
        return self._lengths(self.current, index + 1) - self._arc

    def move_to(self, x: float, y: float) -> None:
        """Takes the location x, y: passes vertices in order, then moves along the current edge.

        A vertex is passed under these conditions:
        - The segment from the last location to this one comes within the tolerance of the vertex.
        - On the segment, this point lies after the point where the previous vertex was passed.
        - The edge that leads to the vertex has been driven.
        On an edge shorter than two tolerances, the tolerance is half of the edge's length, so that
        a location near two vertices skips no edge. The last vertex is never passed here, because
        only the robot can report its arrival (`complete_current`).
        """
        before, self._place = self._place, (x, y)
        from_t = 0.0
        while self.current < len(self.edges) - 1 and self.end(self.current).id not in self._by_word:
            t = self._entry(before, from_t)
            if t is None:
                break
            self.complete_current()
            from_t = t
        if not self.done:
            begin = _between(before, self._place, from_t)
            self._arc = self._arc_at(self._place, math.dist(begin, self._place))

    def complete_current(self) -> None:
        """Notes that the robot has reached the end of the current edge."""
        self.current += 1
        self._arc = 0.0

    def replace_edges(self, edges: Sequence[int], current: int) -> None:
        """Continues with other edges; `edges[current]` is the current edge."""
        self.edges, self.current = tuple(edges), current

    def has_overshot(self) -> bool:
        """Returns whether the robot is on the next edge but has not passed the vertex before it."""
        if self.current + 1 >= len(self.edges) or self.end(self.current).id in self._by_word:
            return False
        vertex = self.end(self.current)
        following = self.graph.curve(self.edges[self.current + 1]).project(*self._place)
        return (following.distance < self._curve().project(*self._place).distance
                and following.arc_length > 2.0 * self.tolerance
                and math.dist(self._place, vertex.position) > 2.0 * self.tolerance)

    def _entry(self, before: Point, from_t: float) -> Optional[float]:
        """Returns the fraction (0..1) of the segment from `before` at which the robot passes the
        next vertex. None: it does not pass the vertex.
        """
        length = self._curve().length
        tolerance = min(self.tolerance, length / 2.0)
        vertex = self.end(self.current).position
        t = _first_within(before, self._place, vertex, tolerance, from_t)
        if t is None:
            return None
        moved = (t - from_t) * math.dist(before, self._place)
        arc = self._arc_at(_between(before, self._place, t), moved)
        return t if length - arc <= 2.0 * tolerance else None

    def _arc_at(self, place: Point, moved: float) -> float:
        """Returns the arc length of `place` on the current edge, after a movement of `moved` m."""
        return self._curve().project(
            *place, start=self._arc, end=self._arc + 2.0 * moved + SLACK).arc_length

    def _curve(self) -> Curve:
        return self.graph.curve(self.edges[self.current])

    def _lengths(self, first: int, end: int) -> float:
        return sum(self.graph.curve(edge).length for edge in self.edges[first:end])


def _between(a: Point, b: Point, t: float) -> Point:
    return a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])


def _first_within(a: Point, b: Point, centre: Point, radius: float,
                  from_t: float) -> Optional[float]:
    """Returns the smallest t from `from_t` to 1 at which the segment a-b is within `radius` of
    `centre`. None: there is none.
    """
    if math.dist(_between(a, b, from_t), centre) <= radius:
        return from_t
    dx, dy = b[0] - a[0], b[1] - a[1]
    ox, oy = a[0] - centre[0], a[1] - centre[1]
    square = dx * dx + dy * dy
    half = ox * dx + oy * dy
    root = half * half - square * (ox * ox + oy * oy - radius * radius)
    if square == 0.0 or root < 0.0:
        return None
    t = (-half - math.sqrt(root)) / square
    return t if from_t <= t <= 1.0 else None
