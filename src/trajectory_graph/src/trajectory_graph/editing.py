"""Editing operations: pure functions from one draft of a graph to the next. Metres, radians, m/s.

A draft may be what no graph may be: with a vertex, say, that waits to be connected. What
an operation does not touch is the same object in both drafts. Operations raise EditError, and then
nothing has happened.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, FrozenSet, Iterable, List, Mapping, Tuple

import numpy as np

from trajectory_graph.curves import Curve, bezier_arc_lengths, bezier_section
from trajectory_graph.errors import GraphError, TrajectoryGraphError
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex, parts_of

LINE_PARAMETER = 0.25  # m; a line's parameters mean nothing, but the file has them
DEFAULT_SPEED = 0.5  # m/s, of a new edge where none is near to go by
HANDLE_SHARE = 1.0 / 3.0  # of an edge's length that a new spline's handles have
SHORTEST_HANDLE = 0.05  # m


class EditError(TrajectoryGraphError):
    """An operation that cannot be done; the text says why, as one sentence."""


@dataclass(frozen=True)
class Draft:
    """Vertices and edges by id, in the file's order; every edge's vertices are there."""

    vertices: Mapping[int, Vertex]
    edges: Mapping[int, Edge]

    @classmethod
    def of(cls, graph: Graph) -> Draft:
        """The draft that is this graph."""
        return cls(dict(graph.vertices), dict(graph.edges))

    def graph(self) -> Graph:
        """The draft as a graph; raises GraphError where it is not a valid one."""
        return Graph(self.vertices.values(), self.edges.values())

    def vertex(self, id: int) -> Vertex:
        """The vertex `id`; raises EditError."""
        if id not in self.vertices:
            raise EditError(f'There is no vertex {id} any more.')
        return self.vertices[id]

    def edge(self, id: int) -> Edge:
        """The edge `id`; raises EditError."""
        if id not in self.edges:
            raise EditError(f'There is no edge {id} any more.')
        return self.edges[id]

    def edges_at(self, vertex_id: int) -> List[int]:
        """Ids of the edges that touch a vertex."""
        return [edge.id for edge in self.edges.values()
                if vertex_id in (edge.origin, edge.destination)]

    def edge_alone(self, id: int) -> Graph:
        """The graph of one edge and its two vertices; raises GraphError where that is invalid."""
        edge = self.edge(id)
        origin, destination = self.vertices[edge.origin], self.vertices[edge.destination]
        if origin is destination:
            raise GraphError(f'joins vertex {origin.id} to itself', 'edge', id)
        return Graph((origin, destination), (edge,))

    def curve(self, id: int) -> Curve:
        """The curve of an edge; raises GraphError where the edge is invalid."""
        return self.edge_alone(id).curve(id)

    def parts(self) -> Tuple[FrozenSet[int], ...]:
        """The sets of vertices that edges join, the largest first."""
        return parts_of(self.vertices, self.edges.values())

    def with_vertices(self, vertices: Iterable[Vertex]) -> Draft:
        """The draft with these vertices changed or added."""
        return Draft({**self.vertices, **{vertex.id: vertex for vertex in vertices}}, self.edges)

    def with_edges(self, edges: Iterable[Edge]) -> Draft:
        """The draft with these edges changed or added."""
        return Draft(self.vertices, {**self.edges, **{edge.id: edge for edge in edges}})


def snapped(x: float, y: float, grid: float) -> Tuple[float, float]:
    """The place on a grid of `grid` m that is nearest, or the same place where `grid` is 0."""
    if grid <= 0.0 or not math.isfinite(x) or not math.isfinite(y):
        return round(x, 4), round(y, 4)
    return round(round(x / grid) * grid, 6), round(round(y / grid) * grid, 6)


def add_vertex(draft: Draft, x: float, y: float, **fields: Any) -> Tuple[Draft, int]:
    """A vertex without edges; its id is above all others."""
    some = next(iter(draft.vertices.values()), None)
    id = max(draft.vertices, default=0) + 1
    fields.setdefault('theta', 0.0)
    fields.setdefault('frame_id', some.frame_id if some is not None else '')
    return draft.with_vertices([_checked_vertex(Vertex(id, x, y, **fields))]), id


def change_vertex(draft: Draft, id: int, **fields: Any) -> Draft:
    """Other values for fields of a vertex: x, y, theta, label, dock, parking ..."""
    vertex = _checked_vertex(replace(draft.vertex(id), **fields))
    return draft if vertex == draft.vertices[id] else draft.with_vertices([vertex])


def move_vertex(draft: Draft, id: int, x: float, y: float) -> Draft:
    """The vertex at another place; its edges come along."""
    return change_vertex(draft, id, x=x, y=y)


def turn_vertex(draft: Draft, id: int, theta: float) -> Draft:
    """The vertex looking another way."""
    theta = round(math.remainder(theta, 2.0 * math.pi), 6)
    return change_vertex(draft, id, theta=theta, theta_holonomic=theta)


def delete_vertex(draft: Draft, id: int) -> Draft:
    """Without the vertex and the edges that touch it; the last vertex stays."""
    draft.vertex(id)
    if len(draft.vertices) == 1:
        raise EditError('The last vertex stays: a graph needs one.')
    gone = set(draft.edges_at(id))
    return Draft({key: vertex for key, vertex in draft.vertices.items() if key != id},
                 {key: edge for key, edge in draft.edges.items() if key not in gone})


def connect(draft: Draft, origin: int, destination: int, **fields: Any) -> Tuple[Draft, int]:
    """A new edge between two vertices: by default a line, as fast as the edges around."""
    draft.vertex(origin)
    draft.vertex(destination)
    if origin == destination:
        raise EditError(f'An edge cannot join vertex {origin} to itself.')
    for id in draft.edges_at(origin):
        if destination in (draft.edges[id].origin, draft.edges[id].destination):
            raise EditError(f'Edge {id} joins vertices {origin} and {destination} already.')
    id = max(draft.edges, default=0) + 1
    around = [draft.edges[near] for near in draft.edges_at(origin) + draft.edges_at(destination)]
    fields.setdefault('velocity_forward', max(
        (edge.velocity_forward for edge in around), default=DEFAULT_SPEED))
    fields.setdefault('velocity_backwards', max(
        (edge.velocity_backwards for edge in around), default=DEFAULT_SPEED))
    fields.setdefault('param_f', LINE_PARAMETER)
    fields.setdefault('param_b', LINE_PARAMETER)
    return _checked_edge(draft.with_edges([Edge(id, origin, destination, **fields)]), id), id


def change_edge(draft: Draft, id: int, **fields: Any) -> Draft:
    """Other values for fields of an edge: curve_type, param_f, velocity_forward ..."""
    edge = replace(draft.edge(id), **fields)
    if edge == draft.edges[id]:
        return draft
    for end in (edge.origin, edge.destination):
        draft.vertex(end)
    return _checked_edge(draft.with_edges([edge]), id)


def turn_edge_round(draft: Draft, id: int) -> Draft:
    """Origin and destination, and all that goes with them, exchanged; splines keep their shape.

    A spline leaves and enters along its vertices' headings, so both of these turn round, too;
    that is refused where it would bend another spline.
    """
    edge = draft.edge(id)
    turned = replace(edge, origin=edge.destination, destination=edge.origin, param_f=edge.param_b,
                     param_b=edge.param_f, velocity_forward=edge.velocity_backwards,
                     velocity_backwards=edge.velocity_forward)
    if edge.curve_type is CurveType.SPLINE:
        for end in (edge.origin, edge.destination):
            for other in draft.edges_at(end):
                if other != id and draft.edges[other].curve_type is CurveType.SPLINE:
                    raise EditError(f'Edge {id} cannot be turned round: edge {other} is a spline '
                                    f'that follows the heading of vertex {end}, too.')
            draft = turn_vertex(draft, end, draft.vertices[end].theta + math.pi)
    return draft.with_edges([turned])


def delete_edge(draft: Draft, id: int) -> Draft:
    """Without the edge; its vertices stay."""
    draft.edge(id)
    return Draft(draft.vertices, {key: edge for key, edge in draft.edges.items() if key != id})


def make_line(draft: Draft, id: int) -> Draft:
    """The edge as a straight line."""
    return change_edge(draft, id, curve_type=CurveType.LINE)


def make_spline(draft: Draft, id: int) -> Draft:
    """The edge as a spline along its vertices' headings, with handles a third of its length."""
    edge = draft.edge(id)
    if edge.curve_type is CurveType.SPLINE:
        return draft
    origin, destination = draft.vertices[edge.origin], draft.vertices[edge.destination]
    handle = round(max(HANDLE_SHARE * math.dist(origin.position, destination.position),
                       SHORTEST_HANDLE), 3)
    return change_edge(draft, id, curve_type=CurveType.SPLINE, param_f=handle, param_b=handle)


def move_handle(draft: Draft, id: int, at_origin: bool, x: float, y: float) -> Draft:
    """A spline's control point at x, y, by the heading of its vertex and the parameter."""
    edge = draft.edge(id)
    if edge.curve_type is not CurveType.SPLINE:
        raise EditError(f'Edge {id} is a line and has no handles.')
    end = edge.origin if at_origin else edge.destination
    vertex = draft.vertices[end]
    dx, dy = x - vertex.x, y - vertex.y
    length = round(max(math.hypot(dx, dy), SHORTEST_HANDLE), 4)
    theta = math.atan2(dy, dx) if at_origin else math.atan2(-dy, -dx)
    turned = turn_vertex(draft, end, theta)
    return change_edge(turned, id, **{'param_f' if at_origin else 'param_b': length})


def cut_edge(draft: Draft, id: int, fraction: float) -> Tuple[Draft, int]:
    """A new vertex on the edge, at a fraction of its length; two edges that lie on the old one.

    The first keeps the edge's id. Raises EditError at the very ends.
    """
    edge = draft.edge(id)
    if not 0.0 < fraction < 1.0:
        raise EditError(f'Edge {id} is cut between its ends only.')
    try:
        control = draft.edge_alone(id).control_points(id)
    except GraphError as error:
        raise EditError(str(error)) from None
    t = _parameter_at(control, fraction)
    first, second = bezier_section(control, 0.0, t), bezier_section(control, t, 1.0)
    x, y = first[3].tolist()
    theta = math.atan2(*(second[1] - second[0])[::-1].tolist())
    draft, middle = add_vertex(draft, round(x, 4), round(y, 4), theta=round(theta, 6),
                               theta_holonomic=round(theta, 6))
    other = max(draft.edges) + 1
    halves = [replace(edge, destination=middle), replace(edge, id=other, origin=middle)]
    if edge.curve_type is CurveType.SPLINE:
        halves = [replace(half, param_f=math.dist(*part[:2]), param_b=math.dist(*part[2:]))
                  for half, part in zip(halves, (first, second))]
    draft = draft.with_edges(halves)
    for half in (id, other):
        _checked_edge(draft, half)
    return draft, middle


def _parameter_at(control: np.ndarray, fraction: float) -> float:
    """The parameter of a cubic Bezier curve at a fraction of its length."""
    t = np.linspace(0.0, 1.0, 1025)
    arc = bezier_arc_lengths(control, t)
    return float(np.interp(fraction * arc[-1], arc, t))


def _checked_vertex(vertex: Vertex) -> Vertex:
    try:
        Graph((vertex,), ())
    except GraphError as error:
        raise EditError(str(error)) from None
    return vertex


def _checked_edge(draft: Draft, id: int) -> Draft:
    try:
        draft.edge_alone(id)
    except GraphError as error:
        raise EditError(str(error)) from None
    return draft
