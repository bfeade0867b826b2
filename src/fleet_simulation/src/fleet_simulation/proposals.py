"""Proposes changes of the graph at the edges for which robots wait longest.

Each proposal is a separate graph, which is then simulated. If all docks were in use at the same
time, one proposal adds a dock.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, FrozenSet, Iterator, List, NamedTuple, Sequence, Tuple

from trajectory_graph import Edge, Graph, TrajectoryGraphError, Vertex, speed_of, split_edges
from trajectory_graph.drawn_names import edge_name, place_name, vertex_name
from trajectory_graph.editing import Draft
from trajectory_graph.graph import CurveType

_ASIDE = 2.0    # m; distance from an edge to a passing place beside it
_LONGEST = 1.5  # m, longest section when an edge is cut


class Proposal(NamedTuple):
    """One changed graph.

    what  -- the change in words, an imperative such as `cut edge 5`
    name  -- name of the graph's file, without suffix
    graph -- the graph with the change
    docks -- ids of new docks, for all robot types that charge
    """

    what: str
    name: str
    graph: Graph
    docks: FrozenSet[int] = frozenset()


def proposals(graph: Graph, edges: Sequence[int], room: float,
              docks_in_use: int = 0) -> List[Proposal]:
    """Returns the possible changes of the graph, in the order of `edges`.

    edges        -- ids of the edges for which robots wait longest, the longest wait first
    room         -- distance (m) that two robots need between their centres
    docks_in_use -- the largest number of docks in use at the same time
    """
    found: List[Proposal] = []
    if docks_in_use and docks_in_use >= sum(one.dock for one in graph.vertices.values()):
        found += _dock(graph, room)
    if any(graph.curve(id).length > _LONGEST for id in graph.edges):
        found.append(Proposal(f'cut all edges at {_LONGEST:g} m', 'cut_all',
                              split_edges(graph, _LONGEST)))
    for id in edges:
        for make in (_cut, _one_way, _passing_place, _parking):
            found += _valid(make, graph, id, room)
    return found


Make = Callable[[Graph, int, float], Iterator[Tuple[str, str, Sequence[Vertex], Sequence[Edge]]]]
"""Yields changes of a graph at one edge: the change in words, a name, all vertices, all edges."""


def _valid(make: Make, graph: Graph, id: int, room: float) -> Iterator[Proposal]:
    for what, name, vertices, edges in make(graph, id, room):
        try:
            yield Proposal(what, name, Graph(vertices, edges))
        except TrajectoryGraphError:
            continue  # the change breaks a rule of graphs


def _part(graph: Graph, id: int) -> str:
    """Returns the name of an edge (`edge 7`), or of a section by its middle (`edge 7 at 38 %`)."""
    return place_name(graph, id, 0.5) if graph.edges[id].section_of else edge_name(graph, id)


def _in_file(name: str) -> str:
    """Returns the name of an edge, a section or a vertex as part of a file's name."""
    kind, id, *place = name.replace(' %', '').split(' ')
    return '_'.join((id, *place))


def _cut(graph: Graph, id: int,
         _: float) -> Iterator[Tuple[str, str, Sequence[Vertex], Sequence[Edge]]]:
    if graph.curve(id).length <= _LONGEST:
        return
    cut = split_edges(Draft.of(graph).edge_alone(id), _LONGEST)
    whole = graph.edges[id]
    ids = {vertex: vertex if vertex in (whole.origin, whole.destination) else
           max(graph.vertices) + number for number, vertex in enumerate(cut.vertices, 1)}
    first = max(graph.edges) + 1
    yield (f'cut {_part(graph, id)}', f'cut_{_in_file(_part(graph, id))}',
           [*graph.vertices.values(), *(replace(vertex, id=ids[vertex.id]) for vertex in
                                        cut.vertices.values()
                                        if ids[vertex.id] not in graph.vertices)],
           [*(edge for edge in graph.edges.values() if edge.id != id),
            *(replace(edge, id=first + number, origin=ids[edge.origin],
                      destination=ids[edge.destination])
              for number, edge in enumerate(cut.edges.values()))])


def _one_way(graph: Graph, id: int,
             _: float) -> Iterator[Tuple[str, str, Sequence[Vertex], Sequence[Edge]]]:
    edge = graph.edges[id]
    if edge.velocity_forward <= 0.0 or edge.velocity_backwards <= 0.0:
        return
    for origin, end, changed in (
            (edge.origin, edge.destination, replace(edge, velocity_backwards=0.0)),
            (edge.destination, edge.origin, replace(edge, velocity_forward=0.0))):
        if _comes_round(graph, changed, end, origin):
            part, first = _part(graph, id), vertex_name(graph, origin)
            yield (f'make {part} one-way from {first} to {vertex_name(graph, end)}',
                   f'one_way_{_in_file(part)}_from_{_in_file(first)}',
                   list(graph.vertices.values()),
                   [changed if one.id == id else one for one in graph.edges.values()])


def _comes_round(graph: Graph, changed: Edge, begin: int, end: int) -> bool:
    """Returns whether a path leads from `begin` to `end` without using the changed edge."""
    seen, ahead = {begin}, [begin]
    while ahead:
        vertex = ahead.pop()
        for signed in graph.edges_from(vertex):
            after = graph.end_vertex(signed).id
            if abs(signed) != changed.id and speed_of(graph, signed) > 0.0 and after not in seen:
                seen.add(after)
                ahead.append(after)
    return end in seen


def _passing_place(graph: Graph, id: int,
                   room: float) -> Iterator[Tuple[str, str, Sequence[Vertex], Sequence[Edge]]]:
    """Adds a spur beside the start of the edge, if there is room."""
    start = graph.edges[id].origin
    for vertices, edges, _ in _spurs(graph, id, room, 'passing place', dock=False):
        name = vertex_name(graph, start)
        file = f'passing_{_in_file(name)}_by_{_in_file(_part(graph, id))}'
        yield f'add a passing place beside {name}', file, vertices, edges
        return


def _dock(graph: Graph, room: float) -> Iterator[Proposal]:
    """Adds a dock on a spur, as near as possible to an existing dock."""
    docks = [vertex.position for vertex in graph.vertices.values() if vertex.dock]
    for id in sorted(graph.edges, key=lambda id: min(
            math.dist(graph.vertices[graph.edges[id].origin].position, dock) for dock in docks)):
        start = graph.edges[id].origin
        if graph.vertices[start].dock:
            continue
        for vertices, edges, dock in _spurs(graph, id, room, 'dock', dock=True):
            name = vertex_name(graph, start)
            yield Proposal(f'add a dock beside {name} (list vertex {dock} under docks in the fleet '
                           'file)', f'dock_{_in_file(name)}', Graph(vertices, edges),
                           frozenset((dock,)))
            return


def _spurs(graph: Graph, id: int, room: float, label: str,
           dock: bool) -> Iterator[Tuple[Sequence[Vertex], Sequence[Edge], int]]:
    """Yields graphs with a spur at the start of an edge: the vertices, the edges, and the new
    vertex.

    The spur is a straight edge to a new vertex, on the left or the right of the edge. For a side
    without room, nothing is yielded.
    """
    edge = graph.edges[id]
    start, heading = graph.vertices[edge.origin], graph.curve(id).heading_at(0.0)
    aside = max(_ASIDE, room + 0.1)
    vertex, spur = max(graph.vertices) + 1, max(graph.edges) + 1
    speed = edge.velocity_forward or edge.velocity_backwards
    for side in (1.0, -1.0):
        x = start.x - side * aside * math.sin(heading)
        y = start.y + side * aside * math.cos(heading)
        nearest = graph.nearest_edge(x, y)
        if nearest is None or nearest[1].distance < room:
            continue
        yield ([*graph.vertices.values(),
                replace(start, id=vertex, x=x, y=y, theta=heading + side * math.pi / 2.0,
                        label=label, dock=dock, parking=None if dock else True)],
               [*graph.edges.values(), Edge(spur, start.id, vertex, CurveType.LINE,
                                            velocity_forward=speed, velocity_backwards=speed)],
               vertex)


def _parking(graph: Graph, id: int,
             _: float) -> Iterator[Tuple[str, str, Sequence[Vertex], Sequence[Edge]]]:
    """Forbids parking on both ends of the edge, except on docks."""
    edge = graph.edges[id]
    ends = {edge.origin, edge.destination}
    if all(graph.vertices[end].parking is False or graph.vertices[end].dock for end in ends):
        return
    part = _part(graph, id)
    yield (f'forbid parking at the ends of {part}', f'no_parking_{_in_file(part)}',
           [replace(vertex, parking=False) if vertex.id in ends and not vertex.dock else vertex
            for vertex in graph.vertices.values()], list(graph.edges.values()))
