"""Finds places at which a robot that follows the edges of a graph turns almost on the spot.

Lengths are in m, angles in rad. A *bend* is a place around which the path turns by more than BEND
within a short stretch. The turn may be in a curve, at the corner where two edges meet, or both.
Turns to the left and turns to the right count the same, and are added along the path, also across
vertices. A corner that alone is a bend ends the sum, because the robot turns on that vertex, and
drives on with its new heading.
"""
from __future__ import annotations

import math
from typing import Dict, List, Set, Tuple

import numpy as np

from trajectory_graph import Graph

BEND = math.radians(45.0)
PITCH = 0.02  # distance between the examined places on an edge


def bends_of(graph: Graph, stretch: float) -> List[Tuple[float, float]]:
    """Returns the bends (x, y): vertices, and points on edges, at intervals of PITCH.

    `stretch` is in m.
    """
    ways = _Ways(graph)
    places = [vertex.position for vertex in graph.vertices.values() if ways.is_corner(vertex.id)]
    for edge in graph.edges:
        places += ways.bends_on(edge, stretch / 2.0)
    return places


def corners_of(graph: Graph, least: float) -> Set[int]:
    """Returns the vertices at which a path turns by more than `least` rad.

    A path that turns back there does not count.
    """
    ways = _Ways(graph)
    return {id for id in graph.vertices if ways.is_corner(id, least)}


class _Ways:
    """The turns of the paths on a graph; caches its results."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._beyond: Dict[Tuple[int, int], float] = {}

    def is_corner(self, vertex_id: int, least: float = BEND) -> bool:
        """Returns whether a path through the vertex, without turning back, turns by more
        than `least`.
        """
        ways_out = self._graph.edges_from(vertex_id)
        return any(self._corner(-way_in, way_out) > least
                   for index, way_out in enumerate(ways_out) for way_in in ways_out[:index])

    def bends_on(self, edge: int, reach: float) -> List[Tuple[float, float]]:
        """Returns the places on an edge at which the turns within `reach` to either side add up to
        a bend.
        """
        curve, whole = self._graph.curve(edge), _millimetres(reach)
        if (float(curve.turned(np.array([curve.length]))[0]) + self._turn_beyond(edge, whole)
                + self._turn_beyond(-edge, whole)) <= BEND:
            return []
        s = np.append(np.arange(0.0, curve.length, PITCH), curve.length)
        turns = self._turn_ahead(edge, s, reach) + self._turn_ahead(-edge, curve.length - s, reach)
        return [curve.point_at(at) for at in s[turns > BEND]]

    def _corner(self, edge: int, following: int) -> float:
        """Returns the angle by which a robot turns on the vertex between two edges."""
        before, after = self._graph.curve(edge), self._graph.curve(following)
        return abs(math.remainder(after.heading_at(0.0) - before.heading_at(before.length),
                                  2.0 * math.pi))

    def _turn_ahead(self, edge: int, s: np.ndarray, reach: float) -> np.ndarray:
        """Returns the angles (N,) by which the path turns
        within `reach` (m) after each arc length of `s` (N,).
        """
        curve = self._graph.curve(edge)
        turn = curve.turned(s + reach) - curve.turned(s)
        beyond = s + reach - curve.length
        for index in np.flatnonzero(beyond > 0.0):
            turn[index] += self._turn_beyond(edge, _millimetres(beyond[index]))
        return turn

    def _turn_beyond(self, edge: int, reach: int) -> float:
        """Returns the largest turn of a path within `reach` mm after the end of a signed edge.

        `reach` is in whole mm, so that all paths that lead to this edge can use a cached result.
        """
        key = edge, reach
        if key not in self._beyond:
            most = 0.0
            for following in self._graph.edges_from(self._graph.end_vertex(edge).id):
                corner = self._corner(edge, following)
                if following != -edge and corner <= BEND:
                    most = max(most, corner + float(
                        self._turn_ahead(following, np.zeros(1), reach / 1000.0)[0]))
            self._beyond[key] = most
        return self._beyond[key]


def _millimetres(length: float) -> int:
    return int(1000.0 * length)
