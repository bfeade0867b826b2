"""Shortest paths along edges, by Dijkstra's algorithm. Lengths are in m."""
from __future__ import annotations

import heapq
from itertools import takewhile
from typing import (
    AbstractSet,
    Callable,
    Dict,
    Iterable,
    Iterator,
    List,
    NamedTuple,
    Sequence,
    Tuple,
)

from trajectory_graph.errors import NoPath
from trajectory_graph.graph import Graph


class Road(NamedTuple):
    """An edge from one vertex to another. `edge`: signed id."""

    end: int
    length: float
    edge: int


class Reached(NamedTuple):
    """A vertex, its distance from the start, and the last edge on the way to it (0: the start)."""

    vertex: int
    distance: float
    edge: int


def nearest_first(start: int, roads: Callable[[int], Iterable[Road]]) -> Iterator[Reached]:
    """Yields all vertices that can be reached, the nearest first.

    roads -- returns the roads that leave a vertex
    """
    reached = set()
    waiting = [(0.0, start, 0)]
    while waiting:
        distance, vertex, edge = heapq.heappop(waiting)
        if vertex in reached:
            continue
        reached.add(vertex)
        yield Reached(vertex, distance, edge)
        for road in roads(vertex):
            if road.end not in reached:
                heapq.heappush(waiting, (distance + road.length, road.end, road.edge))


def distances(graph: Graph, start: int, limit: float,
              without: AbstractSet[int] = frozenset()) -> Dict[int, float]:
    """Returns the distance of each vertex that is within `limit` of the start.

    Each edge can be driven in both directions. Edges whose ids are in `without` cannot be driven.
    """
    near = takewhile(lambda reached: reached.distance <= limit, nearest_first(
        start, _roads_of(graph, lambda edge: abs(edge) not in without)))
    return {reached.vertex: reached.distance for reached in near}


def shortest_route(graph: Graph, vertices: Sequence[int],
                   may_drive: Callable[[int], bool] = lambda edge: True) -> Tuple[int, ...]:
    """Returns the signed edges of the shortest paths from each vertex to the next one.

    may_drive -- whether a signed edge may be driven

    Raises NoPath and UnknownVertex.
    """
    roads = _roads_of(graph, may_drive)
    route: List[int] = []
    for start, end in zip(vertices, vertices[1:]):
        graph.vertex(end)
        edge_to: Dict[int, int] = {}
        for reached in nearest_first(start, roads):
            edge_to[reached.vertex] = reached.edge
            if reached.vertex == end:
                break
        else:
            raise NoPath(start, end)
        path, at = [], end
        while at != start:
            path.append(edge_to[at])
            at = graph.start_vertex(edge_to[at]).id
        route += reversed(path)
    return tuple(route)


def _roads_of(graph: Graph, may_drive: Callable[[int], bool]) -> Callable[[int], Iterable[Road]]:
    return lambda vertex: (Road(graph.end_vertex(edge).id, graph.curve(abs(edge)).length, edge)
                           for edge in graph.edges_from(vertex) if may_drive(edge))
