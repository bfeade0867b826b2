"""Vertices, edges and the graph that consists of them. Units are metres and radians.

Edge ids are positive. A *signed* id also gives the direction: a negative id means that the edge is
driven backwards, from its destination to its origin.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType
from typing import (
    Dict,
    FrozenSet,
    Iterable,
    List,
    Mapping,
    Optional,
    Set,
    Tuple,
    TypeVar,
    Union,
)

import numpy as np

from trajectory_graph import curves
from trajectory_graph.curves import Curve, Projection
from trajectory_graph.errors import GraphError, UnknownEdge, UnknownVertex

SHORTEST_EDGE = 1e-3  # m
LARGEST_NUMBER = 1e6  # m, rad or m/s; a larger number is a mistake


class CurveType(Enum):
    """The shape of an edge between its vertices."""

    SPLINE = 'spline'
    LINE = 'line'


@dataclass(frozen=True)
class Vertex:
    """A point at which edges meet. x, y in m, angles in rad; `frame_id` is not a TF frame.

    dock    -- whether robots charge here
    parking -- whether a robot may stand here for ever; None: the graph does not say
    """

    id: int
    x: float
    y: float
    theta: float
    theta_holonomic: float = 0.0
    label: str = ''
    frame_id: str = ''
    dock: bool = False
    parking: Optional[bool] = None

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y, in m."""
        return self.x, self.y


@dataclass(frozen=True)
class Edge:
    """A curve from vertex `origin` to vertex `destination`; lengths in m, speeds in m/s.

    section_of -- if `split_edges` made this edge: id of the drawn edge of which it is a section;
        0: this edge itself was drawn. Only texts use this id, so comparisons ignore it
    """

    id: int
    origin: int
    destination: int
    curve_type: CurveType = CurveType.LINE
    param_f: float = 0.0
    param_b: float = 0.0
    velocity_forward: float = 0.0
    velocity_backwards: float = 0.0
    section_of: int = field(default=0, compare=False)

    @property
    def drawn_id(self) -> int:
        """The id of this edge in the graph that a person has drawn."""
        return self.section_of or self.id


_Element = TypeVar('_Element', Vertex, Edge)


class Graph:
    """A valid trajectory graph: ids are unique, edges join two vertices, every vertex has edges.

    Raises GraphError with the wrong element if the graph is not valid. A graph never changes. The
    class has many methods because several packages use it.
    """

    def __init__(self, vertices: Iterable[Vertex], edges: Iterable[Edge]) -> None:
        self.vertices: Mapping[int, Vertex] = MappingProxyType(_by_id('vertex', vertices))
        self.edges: Mapping[int, Edge] = MappingProxyType(_by_id('edge', edges))
        self._edges_from: Dict[int, List[int]] = {id: [] for id in self.vertices}
        self._curves: Dict[int, Curve] = {}
        self._segments: Optional[_Segments] = None
        self._sections: Optional[Mapping[int, Tuple[int, ...]]] = None
        self._check_vertices()
        for edge in self.edges.values():
            self._check_edge(edge)
            self._edges_from[edge.origin].append(edge.id)
            self._edges_from[edge.destination].append(-edge.id)
        self._check_edges_at_vertices()
        self._parts: Optional[Tuple[FrozenSet[int], ...]] = None

    def vertex(self, id: int) -> Vertex:
        """Returns the vertex `id`; raises UnknownVertex."""
        try:
            return self.vertices[id]
        except KeyError:
            raise UnknownVertex(id) from None

    def edge(self, signed_id: int) -> Edge:
        """Returns the edge of a signed id; raises UnknownEdge."""
        try:
            return self.edges[abs(signed_id)]
        except KeyError:
            raise UnknownEdge(signed_id) from None

    def start_vertex(self, signed_id: int) -> Vertex:
        """Returns the vertex at which the edge starts in driving direction."""
        edge = self.edge(signed_id)
        return self.vertices[edge.origin if signed_id > 0 else edge.destination]

    def end_vertex(self, signed_id: int) -> Vertex:
        """Returns the vertex at which the edge ends in driving direction."""
        edge = self.edge(signed_id)
        return self.vertices[edge.destination if signed_id > 0 else edge.origin]

    def edges_at(self, vertex_id: int) -> Tuple[int, ...]:
        """Returns the ids of the edges at the vertex."""
        return tuple(map(abs, self.edges_from(vertex_id)))

    def edges_from(self, vertex_id: int) -> Tuple[int, ...]:
        """Returns the signed ids of the edges at the vertex, in the direction away from it."""
        self.vertex(vertex_id)
        return tuple(self._edges_from[vertex_id])

    @property
    def parts(self) -> Tuple[FrozenSet[int], ...]:
        """The sets of connected vertices, e.g. of two halls or floors; the largest first."""
        if self._parts is None:
            self._parts = parts_of(self.vertices, self.edges.values())
        return self._parts

    def part_of(self, vertex_id: int) -> FrozenSet[int]:
        """Returns the vertices that are connected to this vertex, with the vertex itself."""
        return next(part for part in self.parts if vertex_id in part)

    def is_same(self, other: Optional[Graph]) -> bool:
        """Returns whether the other graph has the same vertices and edges; False for None."""
        return other is not None and (self.vertices, self.edges) == (other.vertices, other.edges)

    def is_end_vertex(self, vertex_id: int) -> bool:
        """Returns whether the vertex has exactly one edge."""
        return len(self.edges_at(vertex_id)) == 1

    def curve(self, signed_id: int) -> Curve:
        """Returns the edge's curve in driving direction."""
        curve = self._curves.get(signed_id)
        if curve is None:
            edge = self.edge(signed_id)
            curve = self._curves[signed_id] = (
                self._curve_of(edge) if signed_id > 0 else self.curve(-signed_id).reversed())
        return curve

    @property
    def sections(self) -> Mapping[int, Tuple[int, ...]]:
        """The sections of each drawn edge, from origin to destination, by the id of the drawn edge.

        An edge that was not cut has itself as its only section.
        """
        if self._sections is None:
            sections: Dict[int, List[Edge]] = {}
            for edge in self.edges.values():
                sections.setdefault(edge.drawn_id, []).append(edge)
            self._sections = MappingProxyType({id: _in_sequence(edges)
                                               for id, edges in sections.items()})
        return self._sections

    def whole_edges(self, ids: Iterable[int]) -> FrozenSet[int]:
        """Returns the ids of all sections of these edges.

        ids -- ids, signed or not, of edges and sections of this graph, or of drawn edges that were
            cut into sections; other ids are returned as they are
        """
        wanted = {abs(id) for id in ids}
        drawn = {self.edges[id].drawn_id if id in self.edges else id for id in wanted}
        return frozenset().union(*(self.sections.get(id, (id,)) for id in drawn))

    def divides_an_edge(self, vertex: int) -> bool:
        """Returns whether the vertex only exists because a drawn edge was cut into sections."""
        drawn = [self.edges[abs(id)].section_of for id in self._edges_from[vertex]]
        return len(drawn) == 2 and drawn[0] == drawn[1] != 0

    def control_points(self, id: int) -> np.ndarray:
        """Returns the control points (4,2), m, of the edge's curve as a cubic Bezier curve."""
        edge = self.edge(id)
        origin, destination = self.vertices[edge.origin], self.vertices[edge.destination]
        if edge.curve_type is CurveType.LINE:
            return curves.line_control(origin.position, destination.position)
        return curves.spline_control(origin.position, origin.theta, edge.param_f,
                                     destination.position, destination.theta, edge.param_b)

    def nearest_edge(self, x: float, y: float) -> Optional[Tuple[int, Projection]]:
        """Returns the id of the edge nearest to x, y (m), and the projection; None without edges.
        """
        if not self.edges:
            return None
        if self._segments is None:
            self._segments = _Segments({id: self.curve(id) for id in self.edges})
        id = self._segments.nearest(x, y)
        return id, self.curve(id).project(x, y)

    def _curve_of(self, edge: Edge) -> Curve:
        if edge.curve_type is CurveType.LINE:
            return curves.line(self.vertices[edge.origin].position,
                               self.vertices[edge.destination].position)
        return curves.cubic_bezier(self.control_points(edge.id))

    def _check_vertices(self) -> None:
        if not self.vertices:
            raise GraphError('the graph has no vertices')
        first = next(iter(self.vertices.values()))
        for vertex in self.vertices.values():
            _check_numbers('vertex', vertex, ('x', 'y', 'theta', 'theta_holonomic'))
            if vertex.frame_id != first.frame_id:
                raise GraphError(
                    f'FrameId is {vertex.frame_id!r}, but {first.frame_id!r} at vertex '
                    f'{first.id}; it must be the same everywhere', 'vertex', vertex.id)

    def _check_edge(self, edge: Edge) -> None:
        for role, id in (('starts', edge.origin), ('ends', edge.destination)):
            if id not in self.vertices:
                raise GraphError(f'{role} at vertex {id}, which does not exist', 'edge', edge.id)
        if edge.origin == edge.destination:
            raise GraphError(f'joins vertex {edge.origin} to itself', 'edge', edge.id)
        names = ('param_f', 'param_b', 'velocity_forward', 'velocity_backwards')
        _check_numbers('edge', edge, names)
        for name in names:
            if getattr(edge, name) < 0:
                raise GraphError(f'{name} is {getattr(edge, name)}, but must not be negative',
                                 'edge', edge.id)
        origin, destination = self.vertices[edge.origin], self.vertices[edge.destination]
        if math.dist(origin.position, destination.position) < SHORTEST_EDGE:
            raise GraphError(f'joins vertices {origin.id} and {destination.id}, '
                             'which are at the same place', 'edge', edge.id)

    def _check_edges_at_vertices(self) -> None:
        """Raises GraphError for a vertex without edges, except in a graph of one vertex."""
        for vertex, edges in self._edges_from.items():
            if not edges and len(self.vertices) > 1:
                raise GraphError('cannot be reached: no edges touch it', 'vertex', vertex)


def parts_of(vertices: Iterable[int], edges: Iterable[Edge]) -> Tuple[FrozenSet[int], ...]:
    """Returns the sets of connected vertices, the largest first."""
    neighbours: Dict[int, List[int]] = {id: [] for id in vertices}
    for edge in edges:
        neighbours[edge.origin].append(edge.destination)
        neighbours[edge.destination].append(edge.origin)
    parts: List[FrozenSet[int]] = []
    seen: Set[int] = set()
    for start in neighbours:
        if start not in seen:
            part, waiting = {start}, [start]
            while waiting:
                for other in neighbours[waiting.pop()]:
                    if other not in part:
                        part.add(other)
                        waiting.append(other)
            seen |= part
            parts.append(frozenset(part))
    return tuple(sorted(parts, key=lambda part: (-len(part), min(part))))


def _in_sequence(sections: List[Edge]) -> Tuple[int, ...]:
    """Returns the ids of the sections of one drawn edge, from its origin to its destination.

    In a file that was edited by hand, some sections may not belong to the chain. They follow after
    the chain, sorted by id.
    """
    after = {edge.origin: edge for edge in sections}
    reached = {edge.destination for edge in sections}
    here = next((edge for edge in sections if edge.origin not in reached), None)
    chain: Dict[int, None] = {}
    while here is not None and here.id not in chain:
        chain[here.id] = None
        here = after.get(here.destination)
    return tuple({**chain, **dict.fromkeys(sorted(edge.id for edge in sections))})


class _Segments:
    """The segments of many curves in one array, for a fast search."""

    def __init__(self, by_id: Mapping[int, Curve]) -> None:
        self._ids = np.concatenate([
            np.full(len(curve.points) - 1, id) for id, curve in by_id.items()])
        self._starts = np.concatenate([curve.points[:-1] for curve in by_id.values()])
        self._steps = np.concatenate([np.diff(curve.points, axis=0) for curve in by_id.values()])
        self._squares = (self._steps ** 2).sum(axis=1)

    def nearest(self, x: float, y: float) -> int:
        offsets = np.array((x, y)) - self._starts
        ahead = np.clip((offsets * self._steps).sum(axis=1) / self._squares, 0.0, 1.0)
        distances = ((offsets - ahead[:, None] * self._steps) ** 2).sum(axis=1)
        return int(self._ids[np.argmin(distances)])


def _by_id(kind: str, elements: Iterable[_Element]) -> Dict[int, _Element]:
    result: Dict[int, _Element] = {}
    for element in elements:
        if element.id <= 0:
            raise GraphError('an id must be positive', kind, element.id)
        if element.id in result:
            raise GraphError('the id is used twice', kind, element.id)
        result[element.id] = element
    return result


def _check_numbers(kind: str, element: Union[Vertex, Edge], names: Iterable[str]) -> None:
    for name in names:
        if not abs(getattr(element, name)) <= LARGEST_NUMBER:  # `not <=` is also true for NaN
            raise GraphError(f'{name} is {getattr(element, name)}, not a number within '
                             f'{LARGEST_NUMBER:.0f}', kind, element.id)
