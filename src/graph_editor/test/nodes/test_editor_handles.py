"""The handles of vertices and edges in RViz."""
from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from visualization_msgs.msg import InteractiveMarkerControl, Marker

from graph_editor.checking.findings import Severity
from graph_editor.editor.actions import Action
from graph_editor.nodes import handles
from graph_editor.nodes.handles import Look, ShownEdge, ShownVertex
from rviz_drawing import flat
from trajectory_graph import CurveType, Edge, Graph, Vertex
from trajectory_graph.editing import Draft


def draft() -> Draft:
    """Returns a draft with a line from vertex 1 to 2 and a spline from 2 to the dock 3."""
    return Draft.of(Graph(
        [Vertex(1, 0.0, 0.0, 0.0, label='pass'), Vertex(2, 4.0, 0.0, 0.0, label='press'),
         Vertex(3, 6.0, 2.0, math.pi / 2.0, label='dock', dock=True)],
        [Edge(1, 1, 2, velocity_forward=1.0, velocity_backwards=1.0),
         Edge(2, 2, 3, CurveType.SPLINE, 1.0, 1.5, 0.5, 0.0)]))


def shapes(marker, kind: int) -> list:
    return [shape for control in marker.controls for shape in control.markers
            if shape.type == kind]


def test_vertices_are_dragged_in_their_plane_and_have_a_menu():
    marker = handles.vertices_handle(0, [(4.0, 0.0), (0.0, 0.0)])
    assert marker.name == 'vertices 0'
    assert marker.controls[0].interaction_mode == InteractiveMarkerControl.MOVE_PLANE
    delete, = (entry for entry in marker.menu_entries
               if entry.title == Action.DELETE_VERTEX.value)
    assert handles.VERTEX_ACTIONS[delete.id].action is Action.DELETE_VERTEX


def test_the_handle_of_vertices_cannot_be_seen_and_is_on_top_of_their_drawing():
    shape, = shapes(handles.vertices_handle(0, [(4.0, 0.0)]), Marker.TRIANGLE_LIST)
    assert shape.color.a == 0.0 and not shape.colors
    assert {point.z for point in shape.points} == {handles.HANDLE_Z - 0.01}
    disc = np.array([(point.x, point.y) for point in shape.points])
    assert np.hypot(*(disc - (4.0, 0.0)).T).max() == pytest.approx(handles.VERTEX_SIZE / 2.0)
    assert handles.HANDLE_Z - 0.01 > handles.VERTEX_Z + 0.01


def drawn(vertex: Vertex, look: Look = Look()):  # noqa: B008, a value
    return handles.drawn_vertices(0, [with_texts(vertex, look)])


def with_texts(vertex: Vertex, look: Look = Look()) -> ShownVertex:  # noqa: B008, a value
    x, y = vertex.position
    return ShownVertex(vertex, look, (x + 0.3, y + 0.3), (x, y - 0.36) if vertex.label != 'pass'
                       else None)


def test_what_is_seen_of_vertices_moves_with_no_mouse_and_tells_ids_and_labels():
    marker = handles.drawn_vertices(0, [with_texts(vertex)
                                        for vertex in draft().vertices.values()])
    assert marker.controls[0].interaction_mode == InteractiveMarkerControl.NONE
    assert [text.text for text in shapes(marker, Marker.TEXT_VIEW_FACING)] == ['press', 'dock']


def test_ids_differ():
    strokes = {id: [part.corners.round(6).tolist() for part in flat.number(
        id, 0.2, 0.1, handles.BLACK)] for id in range(120)}
    assert len({str(parts) for parts in strokes.values()}) == 120
    assert all(0.0 <= np.array(corner)[..., 1].mean() <= 0.2
               for parts in strokes.values() for corner in parts)


def colours(marker) -> list:
    """Returns the colours of a marker in their order, except the colour of words and numbers."""
    return list(dict.fromkeys(rgb(paint) for paint in shapes(
        marker, Marker.TRIANGLE_LIST)[0].colors if paint != handles.BLACK))


def rgb(paint) -> tuple:
    return paint.r, paint.g, paint.b


@pytest.mark.parametrize('severity, paint', [
    (Severity.ERROR, handles.RED), (Severity.WARNING, handles.AMBER), (None, handles.NAVY)])
def test_what_is_wrong_has_another_colour_also_when_it_is_selected(severity, paint):
    vertex = draft().vertices[1]
    assert colours(drawn(vertex, Look(severity))) == [rgb(paint)]
    assert colours(drawn(vertex, Look(severity, selected=True))) == [
        rgb(paint), rgb(handles.YELLOW)]


def shown(id: int, look: Look = Look()) -> ShownEdge:  # noqa: B008, a value
    graph = draft()
    edge = graph.edges[id]
    return ShownEdge(edge, graph.vertices[edge.origin], graph.vertices[edge.destination], look)


def corners(marker) -> np.ndarray:
    triangles, = shapes(marker, Marker.TRIANGLE_LIST)
    assert len(triangles.colors) == len(triangles.points) and len(triangles.points) % 3 == 0
    return np.array([(point.x, point.y) for point in triangles.points])


def test_an_edge_has_an_arrow_for_each_way_that_may_be_driven():
    one_way = replace(draft().edges[1], velocity_backwards=0.0)
    both, one = shown(1), shown(1)._replace(edge=one_way)
    assert len(corners(handles.edges_handle(0, [both]))) == 6 + 2 * 3
    assert len(corners(handles.edges_handle(0, [one]))) == 6 + 3


def test_edges_of_one_group_share_a_handle_that_is_clicked():
    marker = handles.edges_handle(0, [shown(1), shown(2, Look(Severity.ERROR))])
    assert marker.name == 'edges 0'
    assert marker.controls[0].interaction_mode == InteractiveMarkerControl.BUTTON
    assert colours(marker) == [rgb(handles.BLUE), rgb(handles.RED)]
    assert {handles.edge_group(id) for id in (1, handles.GROUP)} == {0}
    assert handles.edge_group(handles.GROUP + 1) == 1


def test_an_edge_is_drawn_where_it_runs():
    drawn = corners(handles.edges_handle(0, [shown(2)]))
    curve = draft().curve(2)
    assert max(curve.project(x, y).distance for x, y in drawn) < 0.26, (
        'half of an arrow must be wide')
    for x, y in curve.sample(0.3):
        assert np.hypot(*(drawn - (x, y)).T).min() < 0.15


def test_an_edge_without_length_is_still_there_to_be_deleted():
    here, there = Vertex(1, 1.0, 1.0, 0.0), Vertex(2, 1.0, 1.0, 0.0)
    marker = handles.edges_handle(0, [ShownEdge(Edge(1, 1, 2), here, there,
                                                Look(Severity.ERROR))])
    assert colours(marker) == [rgb(handles.RED)]


def test_the_balls_of_a_spline_are_its_control_points():
    places = handles.bender_places(draft(), draft().edges[2])
    control = draft().edge_alone(2).control_points(2)
    assert np.allclose(places, control[1:3])
    assert [marker.name for marker in handles.benders(draft(), draft().edges[2])] == [
        *handles.BENDERS]
