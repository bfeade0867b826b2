"""What stands in RViz for vertices and edges."""
from __future__ import annotations

import math

import numpy as np
import pytest
from visualization_msgs.msg import InteractiveMarkerControl, Marker

from graph_editor.checking.findings import Severity
from graph_editor.editor.actions import Action
from graph_editor.nodes import handles
from graph_editor.nodes.handles import Look
from trajectory_graph import CurveType, Edge, Graph, Vertex
from trajectory_graph.editing import Draft


def draft() -> Draft:
    """A line from 1 to 2, a spline from 2 to 3; 3 is a dock."""
    return Draft.of(Graph(
        [Vertex(1, 0.0, 0.0, 0.0, label='pass'), Vertex(2, 4.0, 0.0, 0.0, label='press'),
         Vertex(3, 6.0, 2.0, math.pi / 2.0, label='dock', dock=True)],
        [Edge(1, 1, 2, velocity_forward=1.0, velocity_backwards=1.0),
         Edge(2, 2, 3, CurveType.SPLINE, 1.0, 1.5, 0.5, 0.0)]))


def shapes(marker, kind: int) -> list:
    return [shape for control in marker.controls for shape in control.markers
            if shape.type == kind]


def test_a_vertex_is_dragged_in_its_plane_and_has_a_menu():
    vertex = draft().vertices[2]
    marker = handles.vertex_handle(vertex, Look())
    assert marker.name == 'vertex 2'
    assert (marker.pose.position.x, marker.pose.position.y) == (4.0, 0.0)
    assert marker.controls[0].interaction_mode == InteractiveMarkerControl.MOVE_PLANE
    delete, = (entry for entry in marker.menu_entries
               if entry.title == Action.DELETE_VERTEX.value)
    assert handles.VERTEX_ACTIONS[delete.id].action is Action.DELETE_VERTEX
    text, = shapes(marker, Marker.TEXT_VIEW_FACING)
    assert text.text == '2 press'


@pytest.mark.parametrize('severity, paint', [
    (Severity.ERROR, handles.RED), (Severity.WARNING, handles.AMBER), (None, handles.NAVY)])
def test_what_is_wrong_has_another_colour_also_when_it_is_selected(severity, paint):
    vertex = draft().vertices[1]
    for selected in (False, True):
        discs = shapes(handles.vertex_handle(vertex, Look(severity, selected)), Marker.CYLINDER)
        assert discs[0].color == paint
        assert [disc.color for disc in discs[1:]] == [handles.YELLOW] * selected


def test_an_edge_has_an_arrow_for_each_way_that_may_be_driven():
    assert len(shapes(handles.edge_handle(draft(), draft().edges[1], Look()),
                      Marker.TRIANGLE_LIST)) == 2
    assert len(shapes(handles.edge_handle(draft(), draft().edges[2], Look()),
                      Marker.TRIANGLE_LIST)) == 1


def test_an_edge_is_drawn_where_it_runs():
    marker = handles.edge_handle(draft(), draft().edges[2], Look())
    strip, = shapes(marker, Marker.LINE_STRIP)
    points = np.array([(point.x, point.y) for point in strip.points]) + (
        marker.pose.position.x, marker.pose.position.y)
    assert points[0] == pytest.approx((4.0, 0.0)) and points[-1] == pytest.approx((6.0, 2.0))
    assert len(points) > 10
    assert marker.controls[0].interaction_mode == InteractiveMarkerControl.BUTTON


def test_an_edge_without_length_is_still_there_to_be_deleted():
    here = Vertex(1, 1.0, 1.0, 0.0)
    edge = Edge(1, 1, 2)
    wrong = Draft({1: here, 2: Vertex(2, 1.0, 1.0, 0.0)}, {1: edge})
    marker = handles.edge_handle(wrong, edge, Look(Severity.ERROR))
    assert shapes(marker, Marker.LINE_STRIP)[0].color == handles.RED


def test_the_balls_of_a_spline_are_its_control_points():
    places = handles.bender_places(draft(), draft().edges[2])
    control = draft().edge_alone(2).control_points(2)
    assert np.allclose(places, control[1:3])
    assert [marker.name for marker in handles.benders(draft(), draft().edges[2])] == [
        *handles.BENDERS]
