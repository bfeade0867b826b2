"""The graph: look-ups in both driving directions, and errors that make a graph invalid."""
from __future__ import annotations

import math

import pytest
from graph_builders import dissertation_graph, graph_of, spline_graph

from trajectory_graph import Edge, Graph, GraphError, UnknownEdge, UnknownVertex, Vertex

TWO = {1: (0.0, 0.0), 2: (2.0, 0.0)}


def test_a_negative_id_is_the_edge_driven_backwards():
    graph = spline_graph()
    assert (graph.start_vertex(1).id, graph.end_vertex(1).id) == (1, 2)
    assert (graph.start_vertex(-1).id, graph.end_vertex(-1).id) == (2, 1)
    assert graph.curve(-1).point_at(0.0) == pytest.approx((2.0, 2.0))
    assert graph.curve(-1).length == pytest.approx(graph.curve(1).length)


def test_end_vertices_are_touched_by_one_edge():
    graph = dissertation_graph()
    assert [id for id in graph.vertices if graph.is_end_vertex(id)] == [1, 6, 3]
    assert graph.edges_at(2) == (1, 4, 2)


def test_the_edges_from_a_vertex_lead_away_from_it():
    graph = dissertation_graph()
    assert graph.edges_from(2) == (-1, 4, 2)
    assert {graph.start_vertex(edge).id for edge in graph.edges_from(2)} == {2}


def test_unknown_ids_are_errors_that_carry_them():
    graph = dissertation_graph()
    with pytest.raises(UnknownEdge, match='no edge -99'):
        graph.edge(-99)
    with pytest.raises(UnknownEdge):
        graph.edge(0)
    with pytest.raises(UnknownVertex, match='no vertex 99'):
        graph.edges_at(99)


def test_the_nearest_edge_is_found_with_its_projection():
    id, projection = dissertation_graph().nearest_edge(3.0, 0.2)
    assert id == 4
    assert projection == pytest.approx((0.2, 1.0, 0.5))


def test_a_graph_of_one_vertex_is_valid_and_has_no_nearest_edge():
    assert Graph([Vertex(1, 0.0, 0.0, 0.0)], []).nearest_edge(0.0, 0.0) is None


@pytest.mark.parametrize('vertices, edges, message', [
    ({}, {}, 'no vertices'),
    ({0: (0.0, 0.0)}, {}, 'vertex 0: an id must be positive'),
    (TWO, {-3: (1, 2)}, 'edge -3: an id must be positive'),
    (TWO, {3: (1, 9)}, 'edge 3: ends at vertex 9, which does not exist'),
    (TWO, {3: (9, 1)}, 'edge 3: starts at vertex 9, which does not exist'),
    (TWO, {3: (1, 1)}, 'edge 3: joins vertex 1 to itself'),
    ({1: (0.0, 0.0), 2: (math.nan, 0.0)}, {3: (1, 2)}, 'vertex 2: x is nan'),
    ({1: (0.0, 0.0), 2: (math.inf, 0.0)}, {3: (1, 2)}, 'vertex 2: x is inf'),
    ({1: (1.0, 1.0), 2: (1.0, 1.0)}, {3: (1, 2)}, 'edge 3: .* at the same place'),
    ({**TWO, 5: (9.0, 9.0)}, {3: (1, 2)}, 'vertex 5: cannot be reached: no edges touch it'),
])
def test_a_graph_that_cannot_be_used_is_refused_by_name(vertices, edges, message):
    with pytest.raises(GraphError, match=message):
        graph_of(vertices, edges)


def test_ids_are_unique():
    with pytest.raises(GraphError, match='vertex 1: the id is used twice'):
        Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(1, 1.0, 0.0, 0.0)], [])


def test_one_frame_id_everywhere():
    with pytest.raises(GraphError, match="vertex 2: FrameId is 'b', but 'a' at vertex 1"):
        Graph([Vertex(1, 0.0, 0.0, 0.0, frame_id='a'), Vertex(2, 1.0, 0.0, 0.0, frame_id='b')],
              [Edge(1, 1, 2)])


def test_lengths_and_speeds_are_not_negative():
    vertices = [Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 1.0, 0.0, 0.0)]
    with pytest.raises(GraphError, match='edge 1: param_b is -0.5, but must not be negative'):
        Graph(vertices, [Edge(1, 1, 2, param_b=-0.5)])
