"""Routes: continuity, and the rule that converts edges to vertices."""
from __future__ import annotations

import pytest
from graph_builders import dissertation_graph
from hypothesis import given
from hypothesis import strategies as st

from trajectory_graph import (
    DiscontinuousRoute,
    Edge,
    ForbiddenDirection,
    Graph,
    UnknownEdge,
    Vertex,
    check_drivable,
    check_route,
    route_vertices,
)


def test_the_dissertations_example():
    assert route_vertices(dissertation_graph(), [1, 4, 5]) == [2, 7, 6]


def test_out_and_back_over_one_edge():
    assert route_vertices(dissertation_graph(), [1, -1, 1]) == [2, 1, 2]


def test_no_edges_no_vertices():
    assert route_vertices(dissertation_graph(), []) == []


def test_a_gap_names_both_edges():
    with pytest.raises(DiscontinuousRoute, match='Edge 1 ends at vertex 2, but the next edge 5 '
                                                 'starts at vertex 7') as caught:
        check_route(dissertation_graph(), [1, 5])
    assert (caught.value.first, caught.value.second) == (1, 5)


def test_an_unknown_edge_is_named_before_any_gap():
    with pytest.raises(UnknownEdge, match='no edge -77'):
        check_route(dissertation_graph(), [1, 5, -77])


def test_an_edge_may_be_driven_only_in_a_direction_that_has_a_speed():
    places = [Vertex(id, float(id), 0.0, 0.0) for id in (1, 2, 3)]
    sections = [Edge(51, 1, 2, velocity_forward=0.8, section_of=5),
                Edge(52, 2, 3, velocity_forward=0.8, section_of=5)]
    graph = Graph(places, sections)
    check_drivable(graph, [51, 52])
    check_route(graph, [51, 52, -52])
    with pytest.raises(ForbiddenDirection, match='forbids driving over edge -5: ') as caught:
        check_drivable(graph, [51, 52, -52, -51])
    assert caught.value.id == -52


@st.composite
def walks(draw):
    """Draws a random continuous route over the graph."""
    graph = dissertation_graph()
    at, route = 1, []
    for _ in range(draw(st.integers(1, 12))):
        route.append(draw(st.sampled_from(graph.edges_from(at))))
        at = graph.end_vertex(route[-1]).id
    return route


@given(walks())
def test_the_rule_as_the_contract_words_it(route):
    graph = dissertation_graph()
    pairs = [vertex for edge in route
             for vertex in (graph.start_vertex(edge).id, graph.end_vertex(edge).id)]
    rest = pairs[1:]
    expected = [v for i, v in enumerate(rest) if i == 0 or rest[i - 1] != v]
    assert route_vertices(graph, route) == expected
