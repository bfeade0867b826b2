"""The graph of a fleet in RViz: edges, closed edges, vertices, parking and docks."""
from __future__ import annotations

from typing import Collection, List, Tuple

from visualization_msgs.msg import Marker

from rviz_drawing import drawing
from rviz_drawing.text_places import text_size
from trajectory_graph import Graph, Vertex
from trajectory_graph.placing import Box, box_around

EDGE, CLOSED = drawing.colour(0.55, 0.56, 0.62), drawing.colour(1.0, 0.18, 0.15)
PARKING, DOCK = drawing.colour(0.25, 0.45, 0.95, 0.55), drawing.colour(0.2, 0.8, 0.35, 0.7)
NAME = drawing.colour(0.82, 0.83, 0.88)
EDGE_WIDTH, CLOSED_WIDTH = 0.05, 0.14
RING, SQUARE = 0.16, 0.62
NAME_HEIGHT = 0.32
SEEN = 2.0  # m around the graph; the buttons are above that
_Z = 0.02


def graph_markers(graph: Graph, closed: Collection[int], parking: Collection[int],
                  docks: Collection[int]) -> List[Marker]:
    """All markers of the graph. `closed` has ids of edges, `parking` and `docks` of vertices.

    A vertex that only divides a drawn edge is drawn without its id.
    """
    shut = [id for id in graph.edges if id in closed]
    markers: List[Marker] = [
        drawing.lines('edges', 0, EDGE, EDGE_WIDTH,
                      [graph.curve(id).sample(drawing.STEP) for id in graph.edges
                       if id not in closed], _Z),
        drawing.lines('closed', 0, CLOSED, CLOSED_WIDTH,
                      [graph.curve(id).sample(drawing.STEP) for id in shut], 2 * _Z),
        drawing.lines('vertices', 0, EDGE, EDGE_WIDTH,
                      [drawing.ring(vertex.position, RING if is_place(graph, vertex.id) else 0.06)
                       for vertex in graph.vertices.values()], _Z)]
    for namespace, ids, paint in (('parking', parking, PARKING), ('docks', docks, DOCK)):
        for id in ids:
            if id in graph.vertices:
                markers.append(drawing.shape(
                    Marker.CUBE, namespace, id, paint, (SQUARE, SQUARE, 0.01),
                    drawing.pose_at(graph.vertices[id].position, z=_Z / 2)))
    for id in shut:
        curve = graph.curve(id)
        x, y = curve.point_at(curve.length / 2.0)
        markers.append(drawing.text('closed_names', id, 'closed', (x, y + 0.4), 0.32, CLOSED))
    for vertex in graph.vertices.values():
        if is_place(graph, vertex.id):
            markers.append(drawing.text('names', vertex.id, str(vertex.id), _name_place(vertex),
                                        NAME_HEIGHT, NAME, z=0.1))
    return markers


def name_boxes(graph: Graph) -> List[Box]:
    """The boxes of the vertices' ids."""
    return [box_around(_name_place(vertex), text_size(str(vertex.id), NAME_HEIGHT))
            for vertex in graph.vertices.values() if is_place(graph, vertex.id)]


def window_of(graph: Graph) -> Box:
    """What people see of the surroundings of a graph in the view that the fleet's RViz begins with.
    """
    xs = [vertex.x for vertex in graph.vertices.values()]
    ys = [vertex.y for vertex in graph.vertices.values()]
    return min(xs) - SEEN, min(ys) - SEEN, max(xs) + SEEN, max(ys) + SEEN


def _name_place(vertex: Vertex) -> Tuple[float, float]:
    return vertex.x + 0.34, vertex.y - 0.38


def is_place(graph: Graph, vertex: int) -> bool:
    """Returns whether the vertex is a destination, not only a point that divides a long edge."""
    return not graph.divides_an_edge(vertex)
