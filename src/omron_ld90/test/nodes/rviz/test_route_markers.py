"""What of the graph and the route is drawn, and in which colour."""
from __future__ import annotations

import math

import pytest
from visualization_msgs.msg import Marker

from omron_ld90.bridge.route_protocol import EdgeState
from omron_ld90.bridge.route_watch import EdgeProgress
from omron_ld90.nodes.rviz.route_markers import COMING, CURRENT, ENDED, graph_markers, route_markers
from trajectory_graph import CurveType, Edge, Graph, Vertex

PROCESSING, COMPLETE, FAILED = EdgeState.PROCESSING, EdgeState.COMPLETE, EdgeState.FAILED


@pytest.fixture
def graph() -> Graph:
    """1 -> 2 -> 3, the second edge a curve; all driven along +x."""
    return Graph(
        [Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 4.0, 0.0, 0.0), Vertex(3, 8.0, 2.0, 0.0)],
        [Edge(1, 1, 2), Edge(2, 2, 3, CurveType.SPLINE, 1.0, 1.0)])


def of(array, namespace: str) -> list:
    return [marker for marker in array.markers if marker.ns == namespace]


def colours(array) -> list:
    return [marker.color for marker in of(array, 'route')]


def test_every_array_begins_by_taking_away_what_was_shown(graph):
    for array in (graph_markers(graph, 1, 'map'), graph_markers(None, 1, 'map'),
                  route_markers(graph, [], 'map'), route_markers(None, [], 'map')):
        assert array.markers[0].action == Marker.DELETEALL


def test_without_a_graph_nothing_is_drawn():
    route = [EdgeProgress(1, PROCESSING)]
    assert len(graph_markers(None, 1, 'map').markers) == 1
    assert len(route_markers(None, route, 'map').markers) == 1


def test_edges_are_drawn_as_their_curves(graph):
    (edges,) = of(graph_markers(graph, 1, 'map'), 'edges')
    assert edges.header.frame_id == 'map'
    drawn = [(point.x, point.y) for point in edges.points]
    for x, y in graph.curve(2).sample(0.5):
        assert min(math.hypot(x - px, y - py) for px, py in drawn) < 0.06


def test_each_vertex_shows_its_id_and_the_dock_and_the_ends_have_more_rings(graph):
    array = graph_markers(graph, 1, 'map')
    assert [marker.text for marker in of(array, 'vertex_ids')] == ['1', '2', '3']
    (rings,) = of(array, 'vertices')
    radii = {vertex: {round(math.hypot(point.x - x, point.y - y), 2) for point in rings.points
                      if math.hypot(point.x - x, point.y - y) < 1.0}
             for vertex, x, y in ((1, 0.0, 0.0), (2, 4.0, 0.0), (3, 8.0, 2.0))}
    assert [len(radii[vertex]) for vertex in (1, 2, 3)] == [3, 1, 2]


def test_an_id_that_the_map_shows_already_is_not_drawn_twice(graph):
    named = {'1': (0.1, 0.0), '2': (0.0, 0.0), 'charger': (8.0, 2.0)}  # 2 stands elsewhere
    array = graph_markers(graph, 1, 'map', named)
    assert [marker.text for marker in of(array, 'vertex_ids')] == ['2', '3']


def test_what_is_done_current_and_coming_differs_in_colour(graph):
    route = [EdgeProgress(1, COMPLETE), EdgeProgress(2, PROCESSING), EdgeProgress(-2, PROCESSING)]
    array = route_markers(graph, route, 'map')
    assert colours(array) == [ENDED[COMPLETE], CURRENT, COMING]


def test_a_failed_edge_is_red(graph):
    array = route_markers(graph, [EdgeProgress(1, COMPLETE), EdgeProgress(2, FAILED)], 'map')
    assert colours(array) == [ENDED[COMPLETE], ENDED[FAILED]]


@pytest.mark.parametrize('edge, heading', [(1, 0.0), (-1, math.pi)])
def test_an_edge_points_the_way_it_is_driven(graph, edge, heading):
    array = route_markers(graph, [EdgeProgress(edge, PROCESSING)], 'map')
    (head,) = of(array, 'route_directions')
    tip, right, left = head.points
    back = ((right.x + left.x) / 2, (right.y + left.y) / 2)
    assert math.cos(math.atan2(tip.y - back[1], tip.x - back[0]) - heading) == pytest.approx(1.0)


def test_an_arrowhead_turns_its_bright_side_up(graph):
    (heads,) = of(graph_markers(graph, 1, 'map'), 'directions')
    for a, b, c in zip(*[iter(heads.points)] * 3):
        assert (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0


def test_an_edge_that_the_graph_does_not_know_is_left_out(graph):
    array = route_markers(graph, [EdgeProgress(99, FAILED), EdgeProgress(1, FAILED)], 'map')
    assert len(of(array, 'route')) == 1
