"""Progress: vertices are passed in order, percentages grow, no edge is skipped."""
from __future__ import annotations

import math

import pytest
from bridge_builders import dissertation_graph, graph_of
from hypothesis import given
from hypothesis import strategies as st

from omron_ld90.bridge.route_progress import RouteProgress
from route_protocol.values import SymbolicPose
from trajectory_graph import CurveType, Edge, Graph, Vertex


def progress_on(graph, edges, place, tolerance=0.3, by_word=()):
    return RouteProgress(graph, edges, tolerance, by_word, place)


def test_the_percentage_is_the_projection_onto_the_edge():
    progress = progress_on(dissertation_graph(), (1, 4), (0.0, 0.0))
    progress.move_to(1.0, 0.2)
    assert progress.pose == SymbolicPose(1, pytest.approx(25.0))


def test_an_edge_driven_backwards_counts_from_its_destination():
    progress = progress_on(dissertation_graph(), (-4, -1), (8.0, 0.0))
    progress.move_to(7.0, 0.0)
    assert progress.pose == SymbolicPose(-4, pytest.approx(25.0))


def test_the_percentage_never_falls():
    progress = progress_on(dissertation_graph(), (1, 4), (0.0, 0.0))
    progress.move_to(2.0, 0.0)
    progress.move_to(1.9, 0.0)
    assert progress.pose.percentage == pytest.approx(50.0)


def test_a_vertex_between_two_locations_is_passed_by_the_segment():
    progress = progress_on(dissertation_graph(), (1, 4), (0.0, 0.0))
    progress.move_to(3.6, 0.1)
    assert progress.current == 0
    progress.move_to(4.4, 0.1)  # neither position is within 0.3 m of (4, 0)
    assert progress.current == 1
    assert progress.pose == SymbolicPose(4, pytest.approx(10.0))


def test_two_vertices_can_be_passed_by_one_segment_in_order():
    progress = progress_on(dissertation_graph(), (1, 4, 5), (3.0, 0.0))
    progress.move_to(8.1, 0.0)
    assert progress.current == 2


def test_two_vertices_within_one_tolerance_skip_no_edge():
    graph = graph_of({1: (0, 0), 2: (4, 0), 3: (4.2, 0), 4: (8, 0)},
                     {1: (1, 2), 2: (2, 3), 3: (3, 4)})
    progress = progress_on(graph, (1, 2, 3), (0.0, 0.0))
    progress.move_to(3.9, 0.0)
    assert progress.current == 1
    progress.move_to(4.0, 0.0)
    assert progress.current == 1
    progress.move_to(4.15, 0.0)
    assert progress.current == 2


def test_an_edge_that_ends_near_its_start_is_driven_before_it_is_passed():
    """A loop of 6 m whose ends are 0.25 m apart."""
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 0.0, 0.25, math.pi),
                   Vertex(3, -3.0, 0.25, 0.0)],
                  [Edge(1, 1, 2, CurveType.SPLINE, 4.0, 4.0), Edge(2, 2, 3)])
    progress = progress_on(graph, (1, 2), (0.0, 0.0))
    progress.move_to(0.05, 0.1)
    assert progress.current == 0
    for x, y in graph.curve(1).sample(0.4):
        assert progress.current == 0 or math.hypot(x, y - 0.25) <= 0.3
        progress.move_to(x, y)
    assert progress.current == 1


def test_the_last_vertex_is_not_passed_but_arrived_at():
    progress = progress_on(dissertation_graph(), (1,), (0.0, 0.0))
    progress.move_to(4.0, 0.0)
    assert not progress.done
    assert progress.pose.percentage == pytest.approx(99.9)
    progress.complete_current()
    assert progress.pose == SymbolicPose(1, 100.0)


def test_a_vertex_of_arrival_by_word_is_not_passed():
    progress = progress_on(dissertation_graph(), (1, 4), (0.0, 0.0), by_word=(2,))
    progress.move_to(5.0, 0.0)
    assert progress.current == 0
    assert progress.next_stop == 0


def test_the_distance_to_the_end_follows_the_route():
    progress = progress_on(dissertation_graph(), (1, 4, 5), (1.0, 0.0))
    assert progress.distance_to_end(0) == pytest.approx(3.0)
    assert progress.distance_to_end(2) == pytest.approx(7.0 + math.hypot(4.0, 2.0))


@given(st.lists(st.tuples(st.floats(-2.0, 10.0), st.floats(-2.0, 6.0)), max_size=30))
def test_whatever_is_seen_progress_only_goes_forward(places):
    progress = progress_on(dissertation_graph(), (1, 4, 5), (0.0, 0.0))
    travelled, seen = 0.0, [(0.0, 0.0)]
    for place in places:
        progress.move_to(*place)
        seen.append(place)
        assert progress.travelled >= travelled
        travelled = progress.travelled
        assert progress.current <= 2
        assert 0.0 <= progress.pose.percentage < 100.0
