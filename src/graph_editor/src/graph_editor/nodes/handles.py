"""The handles of vertices, edges and splines as messages.

RViz is slow with many handles and texts, so several elements share one handle. The position of the
mouse shows which element the person means. During a drag, RViz moves a whole handle. So the handles
of vertices are invisible, and the visible drawings of vertices are not handles.

Left button: drags or selects a vertex, selects an edge. Right button: opens a menu. A ball in front
of the selected vertex turns the vertex. Two balls bend the selected spline.
"""
from __future__ import annotations

import math
from functools import lru_cache
from typing import Dict, Iterable, List, NamedTuple, Optional, Tuple

import numpy as np
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl, Marker, MenuEntry

from graph_editor.checking.findings import Severity
from graph_editor.editor.actions import EDGE_MENU, VERTEX_MENU, MenuItem, numbered
from rviz_drawing import drawing, flat
from rviz_drawing.drawing import FRAME, colour
from rviz_drawing.text_places import VertexText, text_size
from trajectory_graph import CurveType, Edge, Graph, GraphError, Vertex
from trajectory_graph.editing import Draft

VERTEX_SIZE, HANDLE_SIZE, EDGE_WIDTH = 0.32, 0.26, 0.08  # m
ID_HEIGHT, ID_PLACE = 0.24, (0.16, 0.19)  # m; from the vertex to the left lower corner of its id
LABEL_HEIGHT, LABEL_PLACE = 0.3, (0.0, -0.36)  # m; from the vertex to the middle of its label
UNLABELLED = ('', 'pass', 'parking')  # labels that are not shown
HEADING_REACH = 0.75  # m; distance from a vertex to the ball that turns it
EDGE_Z, VERTEX_Z, HANDLE_Z, TEXT_Z = 0.02, 0.06, 0.1, 0.14  # m; a click hits the highest drawing
SMOOTH = 0.15  # m; distance between the points of a drawn curve
BLUE, VIOLET, NAVY = colour(0.1, 0.4, 0.8), colour(0.55, 0.25, 0.8), colour(0.12, 0.2, 0.35)
ORANGE, PURPLE, GREEN = colour(0.95, 0.55, 0.0), colour(0.6, 0.0, 0.6), colour(0.0, 0.6, 0.25)
UNSEEN = colour(0.0, 0.0, 0.0, 0.0)
YELLOW, RED, AMBER, BLACK = (colour(1.0, 0.85, 0.1), colour(0.9, 0.05, 0.05),
                             colour(1.0, 0.6, 0.1), colour(0.05, 0.05, 0.05))
GROUP = 25
"""The number of edges in one handle. RViz is slow with a thousand handles, and it updates a handle
with a thousand edges slowly.
"""
VERTEX_GROUP = 10
EDGES, VERTICES, DRAWN = 'edges', 'vertices', 'drawn vertices'
KEPT = 5_000  # largest number of cached drawings; each drag makes new drawings
TURNER, BENDERS = 'turn', ('bend f', 'bend b')
"""The names of the handles of the selected element."""


class Look(NamedTuple):
    """The properties that determine an element's colour together with the element itself."""

    severity: Optional[Severity] = None
    selected: bool = False
    waiting: bool = False
    """Whether the vertex waits to be connected."""


PLAIN = Look()


class ShownVertex(NamedTuple):
    """The values on which the drawing of a vertex depends.

    id_place, label_place -- the middles of the texts of id and label (m); None: not shown
    """

    vertex: Vertex
    look: Look
    id_place: Optional[Tuple[float, float]] = None
    label_place: Optional[Tuple[float, float]] = None


class ShownEdge(NamedTuple):
    """The values on which the drawing of an edge depends."""

    edge: Edge
    origin: Vertex
    destination: Vertex
    look: Look


def _menu(entries: Tuple[MenuItem, ...]) -> Tuple[List[MenuEntry], Dict[int, MenuItem]]:
    rows, by_id = numbered(entries)
    return [MenuEntry(id=id, parent_id=parent, title=title, command_type=MenuEntry.FEEDBACK)
            for id, parent, title in rows], by_id


_VERTEX_ENTRIES, VERTEX_ACTIONS = _menu(VERTEX_MENU)
_EDGE_ENTRIES, EDGE_ACTIONS = _menu(EDGE_MENU)


def edge_group(id: int) -> int:
    """Returns the number of the handle to which an edge belongs."""
    return (id - 1) // GROUP


def vertex_group(id: int) -> int:
    """Returns the number of the handle to which a vertex belongs."""
    return (id - 1) // VERTEX_GROUP


def vertices_handle(group: int, places: Iterable[Tuple[float, float]],
                    moved: Tuple[float, float] = (0.0, 0.0)) -> InteractiveMarker:
    """Returns the handle of a group of vertices: invisible discs at `places`.

    moved -- the distance (x, y) by which the mouse has moved the discs, m
    """
    marker = _handle(f'{VERTICES} {group}', moved)
    marker.menu_entries = _VERTEX_ENTRIES
    shape = flat.flat(flat.moved(flat.disc(VERTEX_SIZE, HANDLE_Z - 0.01, UNSEEN), place)
                         for place in places)
    shape.color, shape.colors = UNSEEN, []
    marker.controls.append(_plane_control('move', 'Vertex: drag, or right click', [shape]))
    return marker


def drawn_vertices(group: int, vertices: Iterable[ShownVertex]) -> InteractiveMarker:
    """Returns the visible drawing of a group of vertices."""
    marker = _handle(f'{DRAWN} {group}', (0.0, 0.0))
    shown = [_drawn_vertex(*one) for one in vertices]
    marker.controls.append(InteractiveMarkerControl(
        name='drawn', interaction_mode=InteractiveMarkerControl.NONE, always_visible=True,
        markers=[flat.together(shape for shape, _ in shown),
                 *(words for _, words in shown if words is not None)]))
    return marker


@lru_cache(maxsize=KEPT)
def id_text(vertex: Vertex) -> VertexText:
    """Returns the id of a vertex as a text beside it."""
    width, height = flat.number_size(vertex.id, ID_HEIGHT)
    edge = (height - ID_HEIGHT) / 2.0
    return VertexText(vertex.position, (width, height),
                      (ID_PLACE[0] - edge + width / 2.0, ID_PLACE[1] - edge + height / 2.0))


@lru_cache(maxsize=KEPT)
def label_text(vertex: Vertex) -> Optional[VertexText]:
    """Returns the label of a vertex as a text beside it; None if the label is not shown."""
    if vertex.label in UNLABELLED:
        return None
    return VertexText(vertex.position, text_size(vertex.label, LABEL_HEIGHT), LABEL_PLACE)


@lru_cache(maxsize=KEPT)
def _drawn_vertex(vertex: Vertex, look: Look, id_place: Optional[Tuple[float, float]],
                  label_place: Optional[Tuple[float, float]]) -> Tuple[Marker, Optional[Marker]]:
    """Returns a marker with a disc, an arrow along the heading and the id, and a marker with the
    label.
    """
    paint = _warning(look) or (PURPLE if vertex.dock else ORANGE if vertex.parking else NAVY)
    parts = [flat.disc(VERTEX_SIZE, VERTEX_Z, paint),
             flat.arrow(vertex.theta, 0.42, 0.2, VERTEX_Z + 0.01, paint)]
    if look.selected or look.waiting:
        halo = VERTEX_SIZE * (2.0 if look.waiting else 1.6)
        parts.append(flat.disc(halo, VERTEX_Z - 0.015, YELLOW))
    parts = [flat.moved(part, vertex.position) for part in parts]
    if id_place is not None:
        width, height = flat.number_size(vertex.id, ID_HEIGHT)
        edge = (height - ID_HEIGHT) / 2.0
        corner = id_place[0] - width / 2.0 + edge, id_place[1] - height / 2.0 + edge
        parts += [flat.moved(stroke, corner)
                  for stroke in flat.number(vertex.id, ID_HEIGHT, TEXT_Z, BLACK)]
    shape = flat.flat(parts)
    if label_place is None:
        return shape, None
    return shape, drawing.text('', 0, vertex.label, label_place, LABEL_HEIGHT, BLACK,
                               TEXT_Z, frame='')


def edges_handle(group: int, edges: Iterable[ShownEdge]) -> InteractiveMarker:
    """Returns the handle of a group of edges. The position of a click shows which edge was clicked.
    """
    marker = _handle(f'{EDGES} {group}', (0.0, 0.0))
    marker.menu_entries = _EDGE_ENTRIES
    marker.controls.append(InteractiveMarkerControl(
        name='select', interaction_mode=InteractiveMarkerControl.BUTTON, always_visible=True,
        description='Edge: click, or right click',
        markers=[flat.together(_drawn(shown) for shown in edges)]))
    return marker


@lru_cache(maxsize=KEPT)
def _drawn(shown: ShownEdge) -> Marker:
    """Returns the curve of an edge, with an arrow for each direction that may be driven."""
    edge, origin, destination, look = shown
    paint = _warning(look) or (VIOLET if edge.curve_type is CurveType.SPLINE else BLUE)
    try:
        curve = Graph((origin, destination), (edge,)).curve(edge.id)
        points = curve.sample(SMOOTH) if edge.curve_type is CurveType.SPLINE else curve.points
        middle, heading = curve.point_at(curve.length / 2.0), curve.heading_at(curve.length / 2.0)
    except GraphError:
        points = np.array((origin.position, destination.position))
        middle, heading = origin.position, 0.0
    parts = [flat.strip(points, EDGE_WIDTH, EDGE_Z, paint)]
    if look.selected:
        parts.append(flat.strip(points, 3.0 * EDGE_WIDTH, EDGE_Z - 0.01, YELLOW))
    parts += [flat.moved(flat.arrow(yaw, 0.24, 0.26, EDGE_Z + 0.01, paint), middle)
              for yaw, speed in ((heading, edge.velocity_forward),
                                 (heading + math.pi, edge.velocity_backwards)) if speed > 0.0]
    return flat.flat(parts)


def turner(vertex: Vertex) -> InteractiveMarker:
    """Returns the ball that turns the selected vertex."""
    marker = _handle(TURNER, turner_place(vertex))
    marker.controls.append(_plane_control('turn', f'Heading of vertex {vertex.id}: drag',
                                          [_ball(YELLOW)]))
    return marker


def turner_place(vertex: Vertex) -> Tuple[float, float]:
    """Returns the position of the ball that turns a vertex."""
    return (vertex.x + HEADING_REACH * math.cos(vertex.theta),
            vertex.y + HEADING_REACH * math.sin(vertex.theta))


def benders(draft: Draft, edge: Edge) -> List[InteractiveMarker]:
    """Returns the balls that bend the selected spline."""
    markers = []
    for name, place, words in zip(BENDERS, bender_places(draft, edge), ('origin', 'destination')):
        marker = _handle(name, place)
        marker.controls.append(_plane_control(
            'bend', f'Bend of edge {edge.id} at its {words}: drag', [_ball(AMBER)]))
        markers.append(marker)
    return markers


def bender_places(draft: Draft, edge: Edge) -> List[Tuple[float, float]]:
    """Returns the two inner control points of a spline."""
    origin, destination = draft.vertices[edge.origin], draft.vertices[edge.destination]
    return [(origin.x + edge.param_f * math.cos(origin.theta),
             origin.y + edge.param_f * math.sin(origin.theta)),
            (destination.x - edge.param_b * math.cos(destination.theta),
             destination.y - edge.param_b * math.sin(destination.theta))]


def _warning(look: Look) -> Optional[ColorRGBA]:
    if look.severity is None:
        return None
    return RED if look.severity is Severity.ERROR else AMBER


def _handle(name: str, place: Tuple[float, float]) -> InteractiveMarker:
    marker = InteractiveMarker(name=name, scale=0.5)  # no description, so RViz shows no label
    marker.header.frame_id = FRAME
    marker.pose = drawing.pose_at(place)
    return marker


def _plane_control(name: str, description: str, shapes: List[Marker]) -> InteractiveMarkerControl:
    """Returns a control that is dragged on the floor."""
    control = InteractiveMarkerControl(
        name=name, description=description, always_visible=True, markers=shapes,
        interaction_mode=InteractiveMarkerControl.MOVE_PLANE)
    control.orientation.w = control.orientation.y = math.sqrt(0.5)  # the normal of the plane is z
    return control


def _ball(paint: ColorRGBA) -> Marker:
    marker = Marker(type=Marker.SPHERE, color=paint, pose=drawing.pose_at((0.0, 0.0), z=HANDLE_Z))
    marker.scale.x = marker.scale.y = marker.scale.z = HANDLE_SIZE
    return marker
