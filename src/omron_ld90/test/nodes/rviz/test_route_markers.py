"""The parts of the graph and the route that are drawn, and their colours."""
from __future__ import annotations

import io
import math

import pytest
from marker_reader import drawn, of

from omron_ld90.nodes.rviz import route_markers
from omron_ld90.nodes.rviz.route_markers import GraphPicture
from omron_ld90.operator.route_watch import EdgeProgress
from route_protocol.values import EdgeState
from trajectory_graph import CurveType, Edge, Graph, Vertex

PROCESSING, COMPLETE, FAILED = EdgeState.PROCESSING, EdgeState.COMPLETE, EdgeState.FAILED
NAMES = {'COMPLETE': 'done', 'CURRENT': 'current', 'COMING': 'coming', 'FAILED': 'failed'}
PAINTS = {tuple(round(part, 2) for part in (paint.r, paint.g, paint.b)): said
          for said, paint in ((NAMES[name], getattr(route_markers, name)) for name in NAMES)}


@pytest.fixture
def graph() -> Graph:
    """Returns a graph 1 -> 2 -> 3; the second edge is a curve; both lead along +x."""
    return Graph(
        [Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 4.0, 0.0, 0.0), Vertex(3, 8.0, 2.0, 0.0)],
        [Edge(1, 1, 2), Edge(2, 2, 3, CurveType.SPLINE, 1.0, 1.0)])


@pytest.fixture
def picture(graph) -> GraphPicture:
    return GraphPicture(graph, 1, 'map')


def seen(array) -> dict:
    """Returns for each colour where the drawn part of the route begins and ends (rounded x)."""
    result = {}
    for marker in of(array, 'route'):
        xs = [point.x for point in marker.points]
        colour = tuple(round(part, 2) for part in (marker.color.r, marker.color.g, marker.color.b))
        result[PAINTS[colour]] = (round(min(xs), 3), round(max(xs), 3))
    return result


def test_without_a_graph_nothing_is_drawn():
    nothing = GraphPicture(None, 1, 'map')
    assert drawn(nothing.graph_markers()) == []
    assert drawn(nothing.route_markers([EdgeProgress(1, PROCESSING)])) == []


def test_without_a_route_no_route_is_drawn(picture):
    assert drawn(picture.route_markers([])) == []


def test_edges_are_drawn_as_their_curves(graph, picture):
    (edges,) = of(picture.graph_markers(), 'edges')
    assert edges.header.frame_id == 'map'
    ends = [(point.x, point.y) for point in edges.points]
    for x, y in graph.curve(2).sample(0.5):
        assert min(math.hypot(x - px, y - py) for px, py in ends) < 0.06


def test_each_vertex_shows_its_id_and_the_dock_and_the_ends_have_more_rings(picture):
    array = picture.graph_markers()
    assert [marker.text for marker in of(array, 'vertex_ids')] == ['1', '2', '3']
    (rings,) = of(array, 'vertices')
    radii = {vertex: {round(math.hypot(point.x - x, point.y - y), 2) for point in rings.points
                      if math.hypot(point.x - x, point.y - y) < 1.0}
             for vertex, x, y in ((1, 0.0, 0.0), (2, 4.0, 0.0), (3, 8.0, 2.0))}
    assert [len(radii[vertex]) for vertex in (1, 2, 3)] == [3, 1, 2]


def test_an_id_that_the_map_shows_already_is_not_drawn_twice(picture):
    named = {'1': (0.1, 0.0), '2': (0.0, 0.0), 'charger': (8.0, 2.0)}  # vertex 2 is elsewhere
    array = picture.graph_markers(named)
    assert [marker.text for marker in of(array, 'vertex_ids')] == ['2', '3']


def test_what_is_done_current_and_coming_differs_in_colour(picture):
    route = [EdgeProgress(1, COMPLETE), EdgeProgress(2, PROCESSING), EdgeProgress(-2, PROCESSING)]
    assert seen(picture.route_markers(route)) == {
        'done': (0.0, 4.0), 'current': (4.0, 8.0), 'coming': (4.0, 8.0)}


def test_a_failed_edge_is_red(picture):
    route = [EdgeProgress(1, COMPLETE), EdgeProgress(2, FAILED)]
    assert seen(picture.route_markers(route)) == {'done': (0.0, 4.0), 'failed': (4.0, 8.0)}


def test_of_an_edge_that_is_driven_twice_what_is_next_is_seen(picture):
    route = [EdgeProgress(1, COMPLETE), EdgeProgress(-1, COMPLETE), EdgeProgress(1, PROCESSING),
             EdgeProgress(2, PROCESSING), EdgeProgress(-2, PROCESSING), EdgeProgress(2, PROCESSING)]
    array = picture.route_markers(route)
    assert seen(array) == {'done': (0.0, 4.0), 'current': (0.0, 4.0), 'coming': (4.0, 8.0)}


def test_a_long_route_costs_no_more_than_the_graph(picture):
    def size(route) -> int:
        buffer = io.BytesIO()
        picture.route_markers(route).serialize(buffer)
        return buffer.tell()

    once = [EdgeProgress(edge, PROCESSING) for edge in (1, 2, -2, -1)]
    assert size(once * 2500) <= 2 * size(once)


def test_a_curve_of_a_thousand_kilometres_has_a_bounded_number_of_points():
    far = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 1e6, 0.0, 0.0)],
                [Edge(1, 1, 2, CurveType.SPLINE, 1e6, 1e6)])
    (edges,) = of(GraphPicture(far, 0, 'map').graph_markers(), 'edges')
    assert len(edges.points) <= 2 * route_markers.MAX_SAMPLES + 2


@pytest.mark.parametrize('edge, heading', [(1, 0.0), (-1, math.pi)])
def test_an_edge_points_the_way_it_is_driven(picture, edge, heading):
    array = picture.route_markers([EdgeProgress(edge, PROCESSING)])
    (head,) = of(array, 'route_directions')
    tip, right, left = head.points
    back = ((right.x + left.x) / 2, (right.y + left.y) / 2)
    assert math.cos(math.atan2(tip.y - back[1], tip.x - back[0]) - heading) == pytest.approx(1.0)


def test_an_arrowhead_turns_its_bright_side_up(picture):
    (heads,) = of(picture.graph_markers(), 'directions')
    for a, b, c in zip(*[iter(heads.points)] * 3):
        assert (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0


def test_an_edge_that_the_graph_does_not_know_is_left_out(picture):
    array = picture.route_markers([EdgeProgress(99, FAILED), EdgeProgress(1, FAILED)])
    assert seen(array) == {'failed': (0.0, 4.0)}
