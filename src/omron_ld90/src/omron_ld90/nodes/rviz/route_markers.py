"""Draws the trajectory graph and the route for RViz. Metres, in the map frame.

An edge is drawn at most once per direction, however long the route is. A curve has at most
MAX_SAMPLES points, however large the graph is.
"""
from __future__ import annotations

import math
from typing import Dict, Iterable, List, Mapping, NamedTuple, Optional, Sequence

import numpy as np
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from omron_ld90.operator.route_watch import EdgeProgress
from route_protocol.values import EdgeState
from rviz_drawing import drawing
from rviz_drawing.fast_messages import PointsMarker
from trajectory_graph import Curve, Graph

STEP = 0.1  # m between the points of a drawn curve
MAX_SAMPLES = 200  # largest number of points of a drawn curve
GRAPH_Z, ROUTE_Z = 0.02, 0.03
EDGE_WIDTH, ROUTE_WIDTH = 0.05, 0.09  # m; thinner lines vanish on a small screen
GRAPH_HEAD, ROUTE_HEAD = 0.25, 0.4  # m, arrowheads
RING, END_RING, DOCK_RING = 0.22, 0.29, 0.36  # m, radii around vertices
NAMED_WITHIN = 0.3  # m: if a goal is this near to a vertex, the vertex shows no id of its own
GRAPH = drawing.colour(0.74, 0.68, 1.0)

COMPLETE = drawing.colour(0.25, 0.75, 0.35)
COMING = drawing.colour(0.30, 0.60, 1.0)
FAILED = drawing.colour(1.0, 0.25, 0.2)
CURRENT = drawing.colour(1.0, 0.85, 0.15)
#: If a route passes an edge more than once, the last of these colours is visible.
_LAYERS = (COMPLETE, COMING, FAILED, CURRENT)


class _Shape(NamedTuple):
    """The drawing of a signed edge: (N, 3) ends of segments; (3, 3) corners of an arrowhead."""

    segments: np.ndarray
    head: np.ndarray


class GraphPicture:
    """Makes the markers of one graph and of routes on it; without a graph they are empty."""

    def __init__(self, graph: Optional[Graph], dock_vertex: int, frame: str) -> None:
        self._graph = graph
        self._dock_vertex = dock_vertex
        self._frame = frame
        self._route_shapes: Dict[int, _Shape] = {}

    def graph_markers(self, named: Optional[Mapping[str, drawing.XY]] = None) -> MarkerArray:
        """Returns the edges as curves with an arrowhead to their end, and the vertices with ids.

        A vertex has one ring, an end vertex has two, and the dock has three. If the name of a goal
        or dock of the map already shows the id at a vertex, the id is not drawn again.

        named -- the positions (m) of the map's goals and docks by name
        """
        if self._graph is None:
            return drawing.complete([])
        shapes = [_shape(self._graph.curve(edge), GRAPH_HEAD, GRAPH_Z)
                  for edge in self._graph.edges]
        rings: List[np.ndarray] = []
        names: List[Marker] = []
        for vertex in self._graph.vertices.values():
            radii = [RING]
            if self._graph.is_end_vertex(vertex.id):
                radii.append(END_RING)
            if vertex.id == self._dock_vertex:
                radii.append(DOCK_RING)
            rings += [drawing.segments(drawing.ring(vertex.position, radius), GRAPH_Z)
                      for radius in radii]
            goal = (named or {}).get(str(vertex.id))
            if goal and math.dist(goal, vertex.position) <= NAMED_WITHIN:
                continue
            place = (vertex.x + radii[-1] + 0.12, vertex.y - radii[-1] - 0.05)  # off most edges
            names.append(drawing.text('vertex_ids', vertex.id, str(vertex.id), place, 0.3, GRAPH,
                                      0.5, self._frame))
        return drawing.complete([
            *self._edges('edges', 'directions', shapes, GRAPH, EDGE_WIDTH, 0),
            self._lines('vertices', rings, GRAPH, EDGE_WIDTH, 0), *names])

    def route_markers(self, route: Sequence[EdgeProgress]) -> MarkerArray:
        """Returns the route's edges, each with an arrowhead in the direction of driving.

        Complete edges are green. The current edge, which is the first that is not complete, is
        yellow. Later edges are blue, failed edges red. Edges that are not in the graph are omitted.
        """
        graph = self._graph
        if graph is None:
            return drawing.complete([])
        layers: Dict[int, int] = {}
        current = next((edge for edge in route if edge.state != EdgeState.COMPLETE), None)
        for edge in route:
            if abs(edge.edge) in graph.edges:
                layer = _LAYERS.index(_paint(edge, current))
                layers[edge.edge] = max(layer, layers.get(edge.edge, 0))
        markers: List[Marker] = []
        for number, paint in enumerate(_LAYERS):
            shapes = [self._route_shape(graph, edge) for edge, layer in layers.items()
                      if layer == number]
            if shapes:
                markers += self._edges('route', 'route_directions', shapes, paint, ROUTE_WIDTH,
                                       number)
        return drawing.complete(markers)

    def _route_shape(self, graph: Graph, edge: int) -> _Shape:
        if edge not in self._route_shapes:
            self._route_shapes[edge] = _shape(graph.curve(edge), ROUTE_HEAD, ROUTE_Z)
        return self._route_shapes[edge]

    def _edges(self, lines: str, heads: str, shapes: Sequence[_Shape], paint: ColorRGBA,
               width: float, number: int) -> List[Marker]:
        """Returns a marker `lines` with many edges, and a marker `heads` with their arrowheads."""
        return [self._lines(lines, [shape.segments for shape in shapes], paint, width, number),
                drawing.many(Marker.TRIANGLE_LIST, heads, number, paint, (1.0, 1.0, 1.0),
                             _joined(shape.head for shape in shapes), self._frame)]

    def _lines(self, namespace: str, segments: Sequence[np.ndarray], paint: ColorRGBA,
               width: float, number: int) -> PointsMarker:
        return drawing.many(Marker.LINE_LIST, namespace, number, paint, (width, 0.0, 0.0),
                            _joined(segments), self._frame)


def _paint(edge: EdgeProgress, current: Optional[EdgeProgress]) -> ColorRGBA:
    if edge.state == EdgeState.FAILED:
        return FAILED
    if edge.state == EdgeState.COMPLETE:
        return COMPLETE
    return CURRENT if edge is current else COMING


def _shape(curve: Curve, head: float, z: float) -> _Shape:
    samples = curve.sample(max(STEP, curve.length / MAX_SAMPLES))
    middle = min((curve.length + head) / 2, curve.length)
    return _Shape(drawing.segments(samples, z),
                  drawing.arrowhead(curve.point_at(middle), curve.heading_at(middle), head, z))


def _joined(blocks: Iterable[np.ndarray]) -> np.ndarray:
    return np.concatenate([np.empty((0, 3)), *blocks])
