"""Changes of the graph where robots wait most: each is a graph of its own, to be simulated.

Where all docks were in use at once, another dock is a proposal, too.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, FrozenSet, Iterator, List, NamedTuple, Sequence, Tuple

from trajectory_graph import Edge, Graph, TrajectoryGraphError, Vertex, split_edges
from trajectory_graph.editing import Draft
from trajectory_graph.graph import CurveType

_ASIDE = 2.0    # m from an edge to a passing place beside it
_LONGEST = 1.5  # m of the sections of an edge that is cut


class Proposal(NamedTuple):
    """A change in words (`To ...`), its file's name, and the graph that it makes.

    docks -- vertices that become docks of all types that charge
    """

    what: str
    name: str
    graph: Graph
    docks: FrozenSet[int] = frozenset()


def proposals(graph: Graph, edges: Sequence[int], room: float,
              docks_in_use: int = 0) -> List[Proposal]:
    """What may be done about the edges that are waited for most, the most first.

    room         -- m that two robots need between their centres
    docks_in_use -- the most docks in use at once
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
"""Changes of a graph at an edge: in words, a name, all vertices and edges."""


def _valid(make: Make, graph: Graph, id: int, room: float) -> Iterator[Proposal]:
    for what, name, vertices, edges in make(graph, id, room):
        try:
            yield Proposal(what, name, Graph(vertices, edges))
        except TrajectoryGraphError:
            continue  # the change breaks a rule of graphs


def _cut(graph: Graph, id: int,
         _: float) -> Iterator[Tuple[str, str, Sequence[Vertex], Sequence[Edge]]]:
    if graph.curve(id).length <= _LONGEST:
        return
    cut = split_edges(Draft.of(graph).edge_alone(id), _LONGEST)
    whole = graph.edges[id]
    ids = {vertex: vertex if vertex in (whole.origin, whole.destination) else
           max(graph.vertices) + number for number, vertex in enumerate(cut.vertices, 1)}
    first = max(graph.edges) + 1
    yield (f'cut edge {id}', f'cut_{id}',
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
            yield (f'make edge {id} one-way from {origin} to {end}', f'one_way_{id}_from_{origin}',
                   list(graph.vertices.values()),
                   [changed if one.id == id else one for one in graph.edges.values()])


def _comes_round(graph: Graph, changed: Edge, begin: int, end: int) -> bool:
    """Is there a way from `begin` to `end` without the edge?"""
    seen, ahead = {begin}, [begin]
    while ahead:
        vertex = ahead.pop()
        for signed in graph.edges_from(vertex):
            edge = graph.edge(signed)
            speed = edge.velocity_forward if signed > 0 else edge.velocity_backwards
            after = graph.end_vertex(signed).id
            if edge.id != changed.id and speed > 0.0 and after not in seen:
                seen.add(after)
                ahead.append(after)
    return end in seen


def _passing_place(graph: Graph, id: int,
                   room: float) -> Iterator[Tuple[str, str, Sequence[Vertex], Sequence[Edge]]]:
    """A spur beside an end of the edge, where there is room."""
    start = graph.edges[id].origin
    for vertices, edges, _ in _spurs(graph, id, room, 'passing place', dock=False):
        yield (f'add a passing place beside vertex {start}', f'passing_{start}', vertices, edges)
        return


def _dock(graph: Graph, room: float) -> Iterator[Proposal]:
    """A spur with a dock, as near to a dock as there is room."""
    docks = [vertex.position for vertex in graph.vertices.values() if vertex.dock]
    for id in sorted(graph.edges, key=lambda id: min(
            math.dist(graph.vertices[graph.edges[id].origin].position, dock) for dock in docks)):
        start = graph.edges[id].origin
        if graph.vertices[start].dock:
            continue
        for vertices, edges, dock in _spurs(graph, id, room, 'dock', dock=True):
            yield Proposal(f'add a dock beside vertex {start} (list vertex {dock} under docks in '
                           'the fleet file)', f'dock_{start}', Graph(vertices, edges),
                           frozenset((dock,)))
            return


def _spurs(graph: Graph, id: int, room: float, label: str,
           dock: bool) -> Iterator[Tuple[Sequence[Vertex], Sequence[Edge], int]]:
    """The graph with an edge to a new vertex on each side of an edge's start where there is room;
    and that vertex."""
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
    """Idle robots are sent elsewhere than to the ends of the edge."""
    edge = graph.edges[id]
    ends = {edge.origin, edge.destination}
    if all(graph.vertices[end].parking is False or graph.vertices[end].dock for end in ends):
        return
    yield (f'send idle robots elsewhere than to the ends of edge {id}', f'no_parking_{id}',
           [replace(vertex, parking=False) if vertex.id in ends and not vertex.dock else vertex
            for vertex in graph.vertices.values()], list(graph.edges.values()))
