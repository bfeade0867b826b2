"""The trajectory graph and the route on it, as RViz draws them. Metres, in the map frame."""
from __future__ import annotations

import math
from typing import List, Mapping, Optional, Sequence

from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker, MarkerArray

from omron_ld90.bridge.route_protocol import EdgeState
from omron_ld90.bridge.route_watch import EdgeProgress
from omron_ld90.nodes.rviz import drawing
from trajectory_graph import Curve, Graph

STEP = 0.1  # m between the points of a drawn curve
GRAPH_Z, ROUTE_Z = 0.02, 0.03
EDGE_WIDTH, ROUTE_WIDTH = 0.05, 0.09  # m; thinner ones vanish on a small screen
RING, END_RING, DOCK_RING = 0.22, 0.29, 0.36  # m, radii around vertices
NAMED_WITHIN = 0.3  # m from a vertex: what stands there names it
GRAPH = drawing.colour(0.74, 0.68, 1.0)
CURRENT = drawing.colour(1.0, 0.85, 0.15)
COMING = drawing.colour(0.30, 0.60, 1.0)
ENDED = {
    EdgeState.COMPLETE: drawing.colour(0.25, 0.75, 0.35),
    EdgeState.FAILED: drawing.colour(1.0, 0.25, 0.2),
}


def graph_markers(graph: Optional[Graph], dock_vertex: int, frame: str,
                  named: Optional[Mapping[str, drawing.XY]] = None) -> MarkerArray:
    """Edges as their curves with an arrowhead from origin to destination, vertices with their ids.

    A vertex is a ring, an end vertex two, the dock three. `named` are the places (m) of the map's
    goals and docks by name: where one of them shows a vertex's id already, it is not drawn twice.
    """
    if graph is None:
        return drawing.complete([])
    edges = drawing.shape(Marker.LINE_LIST, frame, 'edges', GRAPH, (EDGE_WIDTH, 0.0, 0.0))
    heads = drawing.shape(Marker.TRIANGLE_LIST, frame, 'directions', GRAPH, (1.0, 1.0, 1.0))
    rings = drawing.shape(Marker.LINE_LIST, frame, 'vertices', GRAPH, (EDGE_WIDTH, 0.0, 0.0))
    for edge_id in graph.edges:
        curve = graph.curve(edge_id)
        edges.points += drawing.segments(curve.sample(STEP).tolist(), GRAPH_Z)
        heads.points += _head_at_middle(curve, 0.25, GRAPH_Z)
    names = []
    for vertex in graph.vertices.values():
        radii = [RING]
        if graph.is_end_vertex(vertex.id):
            radii.append(END_RING)
        if vertex.id == dock_vertex:
            radii.append(DOCK_RING)
        for radius in radii:
            rings.points += drawing.segments(drawing.circle(vertex.position, radius), GRAPH_Z)
        goal = (named or {}).get(str(vertex.id))
        if goal and math.hypot(goal[0] - vertex.x, goal[1] - vertex.y) <= NAMED_WITHIN:
            continue
        place = (vertex.x + radii[-1] + 0.12, vertex.y - radii[-1] - 0.05)  # off most edges
        names.append(drawing.text(frame, 'vertex_ids', str(vertex.id), place, 0.3, GRAPH,
                                  vertex.id, z=0.5))
    return drawing.complete([edges, heads, rings, *names])


def route_markers(graph: Optional[Graph], route: Sequence[EdgeProgress], frame: str) -> MarkerArray:
    """The route's edges in driving direction: done green, current yellow, coming blue, failed red.

    The current edge is the first that is not complete. Edges that the graph does not know are left
    out.
    """
    if graph is None:
        return drawing.complete([])
    markers: List[Marker] = []
    current = next((edge for edge in route if edge.state != EdgeState.COMPLETE), None)
    for index, edge in enumerate(route):
        if abs(edge.edge) not in graph.edges:
            continue
        paint = ENDED.get(edge.state, CURRENT if edge is current else COMING)
        curve = graph.curve(edge.edge)
        line = drawing.shape(Marker.LINE_STRIP, frame, 'route', paint, (ROUTE_WIDTH, 0.0, 0.0),
                             index)
        line.points = drawing.points(curve.sample(STEP).tolist(), ROUTE_Z)
        head = drawing.shape(Marker.TRIANGLE_LIST, frame, 'route_directions', paint,
                             (1.0, 1.0, 1.0), index)
        head.points = _head_at_middle(curve, 0.4, ROUTE_Z)
        markers += [line, head]
    return drawing.complete(markers)


def _head_at_middle(curve: Curve, length: float, z: float) -> List[Point]:
    middle = min((curve.length + length) / 2, curve.length)
    return drawing.arrowhead(curve.point_at(middle), curve.heading_at(middle), length, z)
