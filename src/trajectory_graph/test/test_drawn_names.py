"""Texts for people name the edges that a person has drawn, not the sections of a cut edge."""
from __future__ import annotations

import re

import pytest
from graph_builders import graph_of
from hypothesis import given
from hypothesis import strategies as st

from trajectory_graph import Edge, Graph, Vertex, split_edges
from trajectory_graph.drawn_names import (
    at_vertex,
    drawn_ids,
    edge_name,
    place_name,
    size_of,
    vertex_name,
)

DRAWN = graph_of({1: (0, 0), 2: (6, 0), 3: (7, 0)}, {7: (1, 2), 8: (2, 3)})
CUT = split_edges(DRAWN, 2.0)  # edge 7: sections 9, 10, 11, with the vertices 4 and 5 between them


def test_a_section_has_the_name_of_the_drawn_edge():
    assert drawn_ids(CUT, (11, -9, 8, 10)) == (7, 8)
    assert [edge_name(CUT, id) for id in (9, -10, 8)] == ['edge 7', 'edge -7', 'edge 8']


@pytest.mark.parametrize(('edge', 'fraction', 'name'), [
    (9, 0.0, 'edge 7 at 0 %'), (10, 0.5, 'edge 7 at 50 %'), (11, 1.0, 'edge 7 at 100 %'),
    (-11, 0.0, 'edge -7 at 0 %'), (-9, 0.5, 'edge -7 at 83 %'), (8, 0.25, 'edge 8 at 25 %')])
def test_a_place_on_a_section_is_told_by_the_length_of_the_drawn_edge(edge, fraction, name):
    assert place_name(CUT, edge, fraction) == name


def test_a_vertex_between_sections_is_told_as_a_place_on_the_drawn_edge():
    assert [vertex_name(CUT, id) for id in (1, 4, 5, 2)] == [
        'vertex 1', 'edge 7 at 33 %', 'edge 7 at 67 %', 'vertex 2']
    assert [at_vertex(CUT, id) for id in (1, 4)] == ['at vertex 1', 'on edge 7 at 33 %']


def test_the_size_of_a_graph_is_that_of_the_drawn_one():
    assert size_of(DRAWN) == '3 vertices and 2 edges'
    assert size_of(CUT) == '3 vertices and 2 edges, cut into 4 sections'


def test_what_the_graph_does_not_have_is_named_as_it_is():
    assert (edge_name(CUT, -99), place_name(CUT, -99, 0.5), vertex_name(CUT, 99)) == (
        'edge -99', 'edge -99 at 50 %', 'vertex 99')


# sections 4 and 5 of edge 9: they end at the same vertex, or they are a ring
@pytest.mark.parametrize('edges', [
    [Edge(4, 1, 2, section_of=9), Edge(5, 3, 2, section_of=9)],  # no chain
    [Edge(4, 1, 2, section_of=9), Edge(5, 2, 1, section_of=9), Edge(6, 2, 3)]])  # a ring
def test_sections_that_a_person_has_edited_still_have_a_name(edges):
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 1.0, 0.0, 0.0), Vertex(3, 2.0, 0.0, 0.0)],
                  edges)
    assert sorted(graph.sections[9]) == [4, 5]
    for id in (4, -5):
        assert place_name(graph, id, 0.5).startswith(f'edge {9 if id > 0 else -9} at ')


@given(longest=st.floats(0.5, 7.0), again=st.floats(0.5, 7.0), fraction=st.floats(0.0, 1.0))
def test_no_name_has_an_id_that_the_drawn_graph_does_not_have(longest, again, fraction):
    cut = split_edges(split_edges(DRAWN, longest), again)
    names = [vertex_name(cut, id) for id in cut.vertices]
    names += [place_name(cut, id, fraction) for edge in cut.edges for id in (edge, -edge)]
    for name in names:
        kind, id = re.match(r'(edge|vertex) -?(\d+)', name).groups()
        assert int(id) in (DRAWN.edges if kind == 'edge' else DRAWN.vertices)


@given(longest=st.floats(0.5, 7.0), share=st.floats(0.0, 1.0))
def test_the_same_point_has_the_same_name_in_the_cut_graph_and_in_the_drawn_one(longest, share):
    cut = split_edges(DRAWN, longest)
    x, y = DRAWN.curve(7).point_at(share * DRAWN.curve(7).length)
    edge, point = cut.nearest_edge(x, y)
    here = place_name(cut, edge, point.fraction)
    id, percent = re.fullmatch(r'edge (\d+) at (\d+) %', here).groups()
    assert id == '7' and abs(int(percent) - 100.0 * share) <= 1.0 or (id, share) == ('8', 1.0)
