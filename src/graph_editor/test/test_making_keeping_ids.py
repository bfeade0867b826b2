"""If a graph is made again, vertices and edges that still exist keep their ids."""
from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph_editor.making.keeping_ids import SAME_PLACE, with_ids_of
from trajectory_graph import CurveType, Edge, Graph, Vertex


def row(*ids: int, pitch: float = 2.0) -> Graph:
    """Returns vertices in a row with these ids. The id of an edge is that of its origin plus 10."""
    vertices = [Vertex(id, k * pitch, 0.0, 0.0) for k, id in enumerate(ids)]
    return Graph(vertices, [Edge(first + 10, first, second, velocity_forward=1.0,
                                 velocity_backwards=0.5) for first, second in zip(ids, ids[1:])])


def test_all_ids_come_back_where_nothing_has_changed():
    old = row(7, 3, 5)
    again = with_ids_of(old, row(1, 2, 3))
    assert again.vertices == {id: old.vertices[id] for id in sorted(old.vertices)}
    assert again.edges == {id: old.edges[id] for id in sorted(old.edges)}


def test_what_is_new_gets_ids_above_all_old_ones():
    again = with_ids_of(row(7, 3), row(1, 2, 3, 4))
    assert [again.vertices[id].x for id in (7, 3, 8, 9)] == [0.0, 2.0, 4.0, 6.0]
    assert sorted(again.edges) == [17, 18, 19]


def test_ids_of_what_is_gone_are_not_used_again():
    old = row(1, 2, 3)
    new = Graph([Vertex(1, 2.0, 0.0, 0.0), Vertex(2, 2.0, 9.0, 0.0)], [Edge(1, 1, 2)])
    again = with_ids_of(old, new)
    assert sorted(again.vertices) == [2, 4]
    assert sorted(again.edges) == [13]


def test_a_line_the_other_way_round_is_turned_with_its_speeds():
    old = row(1, 2, 3, 4)
    turned = [replace(edge, origin=edge.destination, destination=edge.origin, velocity_forward=0.5,
                      velocity_backwards=1.0) if edge.id == 12 else edge
              for edge in old.edges.values()]
    assert with_ids_of(old, Graph(old.vertices.values(), turned)).edges == old.edges


def test_an_edge_at_a_dead_end_is_not_turned_since_a_heading_hangs_on_it():
    old = row(1, 2)
    turned = Graph(old.vertices.values(), [Edge(5, 2, 1)])
    again = with_ids_of(old, turned)
    assert [(edge.id, edge.origin) for edge in again.edges.values()] == [(12, 2)]


def test_a_spline_is_never_turned():
    old = row(1, 2, 3, 4)
    spline = Edge(1, 3, 2, CurveType.SPLINE, 0.5, 0.5)
    edges = [old.edges[11], spline, old.edges[13]]
    again = with_ids_of(old, Graph(old.vertices.values(), edges))
    assert again.edges[14] == replace(spline, id=14)


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), min_size=5, max_size=5))
def test_the_nearest_keeps_the_id_and_only_within_reach(moves):
    old = row(1, 2, 3, 4, 5, pitch=3.0)
    new = Graph([replace(vertex, x=vertex.x + dx, y=dy)
                 for vertex, (dx, dy) in zip(old.vertices.values(), moves)], old.edges.values())
    again = with_ids_of(old, new)
    for id in old.vertices:
        kept = [key for key, vertex in again.vertices.items() if vertex.position
                == new.vertices[id].position] == [id]
        apart = math.dist(old.vertices[id].position, new.vertices[id].position)
        assert kept == (apart <= SAME_PLACE) or apart == pytest.approx(SAME_PLACE)
