"""Where a robot that follows the edges of a graph turns almost on the spot. Metres, radians.

A *bend* is a place about which the way turns by more than BEND within a short stretch. What turns
there may be a curve, or the corner where two edges meet, or both together: turns to either side add
up along the way, through vertices too. A corner that is a bend by itself ends the sum: there the
robot turns on the vertex, and drives on from its new heading.
"""
from __future__ import annotations

import math
from functools import lru_cache
from typing import List, Tuple

import numpy as np

from trajectory_graph import Graph

BEND = math.radians(45.0)
PITCH = 0.02  # between the places on an edge that are looked at


def bends_of(graph: Graph, stretch: float) -> List[Tuple[float, float]]:
    """The places (x, y): vertices, and points PITCH apart on edges; `stretch` is in m."""
    places = [vertex.position for vertex in graph.vertices.values()
              if _is_corner(graph, vertex.id)]
    for edge in graph.edges:
        places += _bends_on(graph, edge, stretch / 2.0)
    return places


def _is_corner(graph: Graph, vertex_id: int) -> bool:
    """Is a way through the vertex, without going back, a bend by itself?"""
    ways_out = graph.edges_from(vertex_id)
    return any(_corner(graph, -way_in, way_out) > BEND
               for index, way_out in enumerate(ways_out) for way_in in ways_out[:index])


def _corner(graph: Graph, edge: int, following: int) -> float:
    """By how much a robot turns on the vertex between two edges."""
    before, after = graph.curve(edge), graph.curve(following)
    return abs(math.remainder(after.heading_at(0.0) - before.heading_at(before.length),
                              2.0 * math.pi))


def _bends_on(graph: Graph, edge: int, reach: float) -> List[Tuple[float, float]]:
    """The places on an edge from which the turns within `reach` to either side are a bend."""
    curve, whole = graph.curve(edge), _millimetres(reach)
    if (float(curve.turned(curve.length)) + _turn_beyond(graph, edge, whole)
            + _turn_beyond(graph, -edge, whole)) <= BEND:
        return []
    s = np.append(np.arange(0.0, curve.length, PITCH), curve.length)
    turns = _turn_ahead(graph, edge, s, reach) + _turn_ahead(graph, -edge, curve.length - s, reach)
    return [curve.point_at(at) for at in s[turns > BEND]]


def _turn_ahead(graph: Graph, edge: int, s: np.ndarray, reach: float) -> np.ndarray:
    """How far (N,) the way turns within `reach` from arc lengths `s` (N,) of a signed edge on."""
    curve = graph.curve(edge)
    turn = curve.turned(s + reach) - curve.turned(s)
    beyond = s + reach - curve.length
    for index in np.flatnonzero(beyond > 0.0):
        turn[index] += _turn_beyond(graph, edge, _millimetres(beyond[index]))
    return turn


@lru_cache(maxsize=100_000)
def _turn_beyond(graph: Graph, edge: int, reach: int) -> float:
    """The most that a way on from the end of a signed edge turns within `reach` mm.

    Whole mm, so that what is known already is found again however many ways lead there.
    """
    most = 0.0
    for following in graph.edges_from(graph.end_vertex(edge).id):
        corner = _corner(graph, edge, following)
        if following != -edge and corner <= BEND:
            most = max(most, corner + float(
                _turn_ahead(graph, following, np.zeros(1), reach / 1000.0)[0]))
    return most


def _millimetres(length: float) -> int:
    return int(1000.0 * length)
