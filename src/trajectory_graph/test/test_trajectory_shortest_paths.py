"""Shortest paths are routes that can be driven, and no detour over one more edge is shorter."""
from __future__ import annotations

import pytest
from graph_builders import graph_of
from hypothesis import given
from hypothesis import strategies as st

from trajectory_graph import Graph, NoPath, UnknownVertex, check_route
from trajectory_graph.shortest_paths import distances, shortest_route

FAR = 1e9  # m
SQUARE = graph_of({1: (0, 0), 2: (4, 0), 3: (4, 4), 4: (0, 4), 5: (8, 0), 8: (20, 20), 9: (21, 20)},
                  {1: (1, 2), 2: (2, 3), 3: (4, 3), 4: (1, 4), 5: (2, 5), 8: (8, 9)})


def test_distances_go_both_ways_along_edges_up_to_a_limit():
    assert distances(SQUARE, 3, 8.0) == pytest.approx({3: 0.0, 2: 4.0, 4: 4.0, 1: 8.0, 5: 8.0})


def test_closed_edges_are_gone_around():
    assert distances(SQUARE, 3, FAR, {2})[2] == pytest.approx(12.0)


def test_a_route_visits_the_vertices_in_sequence():
    assert shortest_route(SQUARE, (5, 2, 3, 2)) == (-5, 2, -2)
    assert shortest_route(SQUARE, (5, 5)) == ()


def test_a_route_uses_no_direction_that_may_not_be_driven():
    assert shortest_route(SQUARE, (2, 3), lambda edge: edge != 2) == (-1, 4, 3)


def test_where_no_path_leads_the_route_is_refused():
    with pytest.raises(NoPath, match='from vertex 5 to vertex 9'):
        shortest_route(SQUARE, (1, 5, 9))
    with pytest.raises(UnknownVertex):
        shortest_route(SQUARE, (1, 4711))


@st.composite
def graphs(draw: st.DrawFn) -> Graph:
    """Draws connected graphs of up to eight vertices."""
    places = draw(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=2, max_size=8,
                           unique=True))
    ends = {k: (draw(st.integers(1, k)), k + 1) for k in range(1, len(places))}
    more = draw(st.lists(st.tuples(st.integers(1, len(places)), st.integers(1, len(places))).filter(
        lambda pair: pair[0] != pair[1]), max_size=6))
    ends.update({100 + k: pair for k, pair in enumerate(more)})
    return graph_of(dict(enumerate(places, 1)), ends)


@given(graphs())
def test_a_route_is_as_long_as_the_distance_and_no_edge_shortens_it(graph):
    found = distances(graph, 1, FAR)
    assert set(found) == set(graph.vertices)
    for vertex, distance in found.items():
        route = shortest_route(graph, (1, vertex))
        check_route(graph, route)
        assert not route or graph.end_vertex(route[-1]).id == vertex
        assert sum(graph.curve(edge).length for edge in route) == pytest.approx(distance)
        for edge in graph.edges_from(vertex):
            further = distance + graph.curve(edge).length
            assert found[graph.end_vertex(edge).id] <= further + 1e-9
