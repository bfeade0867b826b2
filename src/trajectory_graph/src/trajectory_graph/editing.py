"""Editing operations: pure functions from one draft of a graph to the next. Metres, radians, m/s.

A draft may be an invalid graph, e.g. with a vertex that is not connected yet. Elements that an
operation does not change are the same objects in both drafts. An operation that raises EditError
changes nothing.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, FrozenSet, Iterable, List, Mapping, Tuple

import numpy as np

from trajectory_graph.curves import Curve, bezier_arc_lengths, bezier_section
from trajectory_graph.errors import GraphError, TrajectoryGraphError
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex, parts_of

LINE_PARAMETER = 0.25  # m; the parameters of a line have no effect, but the file requires them
DEFAULT_SPEED = 0.5  # m/s; the speed of a new edge without adjacent edges
HANDLE_SHARE = 1.0 / 3.0  # length of a new spline's handles as a share of the edge's length
SHORTEST_HANDLE = 0.05  # m


class EditError(TrajectoryGraphError):
    """An operation that cannot be done; the text gives the reason in one sentence."""


@dataclass(frozen=True)
class Draft:
    """Vertices and edges by id, in the order of the file; both vertices of each edge are present.
    """

    vertices: Mapping[int, Vertex]
    edges: Mapping[int, Edge]

    @classmethod
    def of(cls, graph: Graph) -> Draft:
        """Returns the draft of a graph."""
        return cls(dict(graph.vertices), dict(graph.edges))

    def graph(self) -> Graph:
        """Returns the draft as a graph; raises GraphError if it is not valid."""
        return Graph(self.vertices.values(), self.edges.values())

    def vertex(self, id: int) -> Vertex:
        """Returns the vertex `id`; raises EditError."""
        if id not in self.vertices:
            raise EditError(f'There is no vertex {id} any more.')
        return self.vertices[id]

    def edge(self, id: int) -> Edge:
        """Returns the edge `id`; raises EditError."""
        if id not in self.edges:
            raise EditError(f'There is no edge {id} any more.')
        return self.edges[id]

    def edges_at(self, vertex_id: int) -> List[int]:
        """Returns the ids of the edges at a vertex."""
        return [edge.id for edge in self.edges.values()
                if vertex_id in (edge.origin, edge.destination)]

    def edge_alone(self, id: int) -> Graph:
        """Returns the graph of one edge and its vertices; raises GraphError if it is invalid."""
        edge = self.edge(id)
        origin, destination = self.vertices[edge.origin], self.vertices[edge.destination]
        if origin is destination:
            raise GraphError(f'joins vertex {origin.id} to itself', 'edge', id)
        return Graph((origin, destination), (edge,))

    def curve(self, id: int) -> Curve:
        """Returns the curve of an edge; raises GraphError if the edge is invalid."""
        return self.edge_alone(id).curve(id)

    def parts(self) -> Tuple[FrozenSet[int], ...]:
        """Returns the sets of connected vertices, the largest first."""
        return parts_of(self.vertices, self.edges.values())

    def with_vertices(self, vertices: Iterable[Vertex]) -> Draft:
        """Returns the draft with these vertices changed or added."""
        return Draft({**self.vertices, **{vertex.id: vertex for vertex in vertices}}, self.edges)

    def with_edges(self, edges: Iterable[Edge]) -> Draft:
        """Returns the draft with these edges changed or added."""
        return Draft(self.vertices, {**self.edges, **{edge.id: edge for edge in edges}})


def snapped(x: float, y: float, grid: float) -> Tuple[float, float]:
    """Returns the nearest point of a grid of `grid` m; the same point if `grid` is 0."""
    if grid <= 0.0 or not math.isfinite(x) or not math.isfinite(y):
        return round(x, 4), round(y, 4)
    return round(round(x / grid) * grid, 6), round(round(y / grid) * grid, 6)


def add_vertex(draft: Draft, x: float, y: float, **fields: Any) -> Tuple[Draft, int]:
    """Adds a vertex without edges, with an id above all others. Returns the draft and the id."""
    some = next(iter(draft.vertices.values()), None)
    id = max(draft.vertices, default=0) + 1
    fields.setdefault('theta', 0.0)
    fields.setdefault('frame_id', some.frame_id if some is not None else '')
    return draft.with_vertices([_checked_vertex(Vertex(id, x, y, **fields))]), id


def change_vertex(draft: Draft, id: int, **fields: Any) -> Draft:
    """Changes fields of a vertex: x, y, theta, label, dock, parking ..."""
    vertex = _checked_vertex(replace(draft.vertex(id), **fields))
    return draft if vertex == draft.vertices[id] else draft.with_vertices([vertex])


def move_vertex(draft: Draft, id: int, x: float, y: float) -> Draft:
    """Moves a vertex together with the ends of its edges."""
    return change_vertex(draft, id, x=x, y=y)


def turn_vertex(draft: Draft, id: int, theta: float) -> Draft:
    """Changes the heading of a vertex."""
    theta = round(math.remainder(theta, 2.0 * math.pi), 6)
    return change_vertex(draft, id, theta=theta, theta_holonomic=theta)


def delete_vertex(draft: Draft, id: int) -> Draft:
    """Deletes a vertex and its edges; the last vertex cannot be deleted."""
    draft.vertex(id)
    if len(draft.vertices) == 1:
        raise EditError('The last vertex cannot be deleted: a graph needs one vertex or more.')
    gone = set(draft.edges_at(id))
    return Draft({key: vertex for key, vertex in draft.vertices.items() if key != id},
                 {key: edge for key, edge in draft.edges.items() if key not in gone})


def connect(draft: Draft, origin: int, destination: int, **fields: Any) -> Tuple[Draft, int]:
    """Adds an edge between two vertices; returns the draft and the id.

    By default the edge is a line with the highest speeds of the adjacent edges.
    """
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
    """Changes fields of an edge: curve_type, param_f, velocity_forward ..."""
    edge = replace(draft.edge(id), **fields)
    if edge == draft.edges[id]:
        return draft
    for end in (edge.origin, edge.destination):
        draft.vertex(end)
    return _checked_edge(draft.with_edges([edge]), id)


def turn_edge_round(draft: Draft, id: int) -> Draft:
    """Exchanges the origin and the destination of an edge, and the parameters and speeds of its two
    directions. A spline keeps its shape.

    A spline follows the headings of its vertices, so both headings are turned round. The operation
    is refused if this would bend another spline.
    """
    edge = draft.edge(id)
    turned = replace(edge, origin=edge.destination, destination=edge.origin, param_f=edge.param_b,
                     param_b=edge.param_f, velocity_forward=edge.velocity_backwards,
                     velocity_backwards=edge.velocity_forward)
    if edge.curve_type is CurveType.SPLINE:
        for end in (edge.origin, edge.destination):
            for other in draft.edges_at(end):
                if other != id and draft.edges[other].curve_type is CurveType.SPLINE:
                    raise EditError(f'Edge {id} cannot be turned round: edge {other} is a spline, '
                                    f'and it also follows the heading of vertex {end}.')
            draft = turn_vertex(draft, end, draft.vertices[end].theta + math.pi)
    return draft.with_edges([turned])


def delete_edge(draft: Draft, id: int) -> Draft:
    """Deletes an edge; its vertices stay."""
    draft.edge(id)
    return Draft(draft.vertices, {key: edge for key, edge in draft.edges.items() if key != id})


def make_line(draft: Draft, id: int) -> Draft:
    """Makes an edge a straight line."""
    return change_edge(draft, id, curve_type=CurveType.LINE)


def make_spline(draft: Draft, id: int) -> Draft:
    """Makes an edge a spline that follows the headings of its vertices.

    The length of each handle is HANDLE_SHARE of the distance between the vertices.
    """
    edge = draft.edge(id)
    if edge.curve_type is CurveType.SPLINE:
        return draft
    origin, destination = draft.vertices[edge.origin], draft.vertices[edge.destination]
    handle = round(max(HANDLE_SHARE * math.dist(origin.position, destination.position),
                       SHORTEST_HANDLE), 3)
    return change_edge(draft, id, curve_type=CurveType.SPLINE, param_f=handle, param_b=handle)


def move_handle(draft: Draft, id: int, at_origin: bool, x: float, y: float) -> Draft:
    """Moves a control point of a spline to x, y.

    This changes the heading of the vertex and the parameter of the edge.
    """
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
    """Cuts an edge in two at a fraction of its length; returns the draft and the new vertex's id.

    The two edges lie on the old curve. The first one keeps the id. Raises EditError at the ends.
    """
    edge = draft.edge(id)
    if not 0.0 < fraction < 1.0:
        raise EditError(f'Edge {id} can only be cut between its ends.')
    try:
        control = draft.edge_alone(id).control_points(id)
    except GraphError as error:
        raise EditError(str(error)) from None
    t = _parameter_at(control, fraction)
    first, second = bezier_section(control, 0.0, t), bezier_section(control, t, 1.0)
    x, y = map(float, first[3])
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
    """Returns the parameter of a cubic Bezier curve at a fraction of its length."""
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
