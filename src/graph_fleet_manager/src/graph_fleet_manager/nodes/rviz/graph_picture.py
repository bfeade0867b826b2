"""The graph of a fleet in RViz: edges, closed edges, vertices, parking and docks."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Dict, List, Mapping

from visualization_msgs.msg import Marker

from fleet_core.supervision.looks import ResourceLook
from graph_fleet_manager.nodes.rviz.paints import PAINTS
from rviz_drawing import drawing
from rviz_drawing.text_places import text_size
from trajectory_graph import Graph
from trajectory_graph.placing import (
    ABOVE_FIRST,
    BELOW_RIGHT_FIRST,
    Box,
    MayCover,
    Places,
    box_around,
    box_beside,
    middle_of,
)

EDGE, CLOSED = drawing.colour(0.55, 0.56, 0.62), PAINTS[ResourceLook.SHUT]
PARKING, DOCK = drawing.colour(0.25, 0.45, 0.95, 0.55), drawing.colour(0.2, 0.8, 0.35, 0.7)
NAME = drawing.colour(0.82, 0.83, 0.88)
EDGE_WIDTH, CLOSED_WIDTH = 0.05, 0.14
RING, SQUARE = 0.16, 0.62
NAME_HEIGHT, NAME_AWAY = 0.32, 0.52  # m; NAME_AWAY is beyond the ring of a station
CLOSED_HEIGHT, CLOSED_AWAY = 0.32, 0.25  # m
EDGE_BOX, EDGE_STEP = 0.3, 0.4  # m, size and distance of the boxes that stand for an edge
CLOSED_WORD = 'closed'
SEEN = 2.0  # m; texts may stand in this margin around the graph. The buttons stand outside it
_Z = 0.02


@dataclass(frozen=True)
class GraphTexts:
    """The boxes that the texts of other pictures avoid.

    edges -- the boxes of the edges; texts may cover them if there is no other place
    names -- the boxes of the vertices' ids, by vertex
    """

    edges: Places
    names: Mapping[int, Box]


def place_texts(graph: Graph) -> GraphTexts:
    """Places the ids of the vertices beside them, clear of edges and of each other."""
    edges = Places()
    for id in graph.edges:
        for x, y in graph.curve(id).sample(EDGE_STEP):
            edges.cover(box_around((x, y), (EDGE_BOX, EDGE_BOX)), is_soft=True)
    places, names = Places(beneath=edges), {}
    for vertex in graph.vertices.values():
        if is_place(graph, vertex.id):
            boxes = [box_beside(vertex.position, NAME_AWAY,
                                text_size(str(vertex.id), NAME_HEIGHT), side)
                     for side in BELOW_RIGHT_FIRST]
            names[vertex.id] = boxes[places.place(boxes, may=MayCover.ALL)]
    return GraphTexts(edges, names)


def graph_markers(graph: Graph, texts: GraphTexts, closed: Collection[int],
                  parking: Collection[int], docks: Collection[int]) -> List[Marker]:
    """Returns all markers of the graph. `closed` has ids of edges, `parking` and `docks` of
    vertices.

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
    for id, box in closed_boxes(graph, texts, shut).items():
        markers.append(drawing.text('closed_names', id, CLOSED_WORD, middle_of(box), CLOSED_HEIGHT,
                                    CLOSED))
    for id, box in texts.names.items():
        markers.append(drawing.text('names', id, str(id), middle_of(box), NAME_HEIGHT, NAME, z=0.1))
    return markers


def closed_boxes(graph: Graph, texts: GraphTexts, closed: Collection[int]) -> Dict[int, Box]:
    """Returns the boxes of the words beside closed edges, by edge."""
    places, boxes = Places(beneath=texts.edges), {}
    for box in texts.names.values():
        places.cover(box)
    for id in graph.edges.keys() & closed:
        curve = graph.curve(id)
        beside = [box_beside(curve.point_at(curve.length / 2.0), CLOSED_AWAY,
                             text_size(CLOSED_WORD, CLOSED_HEIGHT), side) for side in ABOVE_FIRST]
        boxes[id] = beside[places.place(beside, may=MayCover.ALL)]
    return boxes


def window_of(graph: Graph) -> Box:
    """Returns the area around a graph that people see in the first view of the fleet's RViz."""
    xs = [vertex.x for vertex in graph.vertices.values()]
    ys = [vertex.y for vertex in graph.vertices.values()]
    return min(xs) - SEEN, min(ys) - SEEN, max(xs) + SEEN, max(ys) + SEEN


def is_place(graph: Graph, vertex: int) -> bool:
    """Returns whether the vertex can be a destination; a vertex that divides an edge cannot."""
    return not graph.divides_an_edge(vertex)
