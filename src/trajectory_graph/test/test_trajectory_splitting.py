"""Long edges cut into sections."""
from __future__ import annotations

import math

import numpy as np
import pytest
from graph_builders import graph_of, spline_graph
from hypothesis import example, given
from hypothesis import strategies as st

from trajectory_graph import CurveType, Edge, Graph, Vertex, load_graph, save_graph, split_edges
from trajectory_graph.cli import split_edges_main

coordinate = st.floats(-20.0, 20.0)
splines = st.builds(
    lambda x, y, a, b, f, g: Graph(
        [Vertex(1, 0.0, 0.0, a), Vertex(2, x, y, b)],
        [Edge(5, 1, 2, CurveType.SPLINE, f, g, 0.4, 0.3)]),
    st.floats(2.0, 20.0), coordinate, st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi),
    st.floats(0.0, 1.0), st.floats(0.0, 1.0))


def test_an_edge_becomes_equal_sections_no_longer_than_asked():
    graph = split_edges(graph_of({1: (0, 0), 2: (5, 0)}, {3: (1, 2)}), 2.0)
    assert [(e.id, e.origin, e.destination) for e in graph.edges.values()] == [
        (4, 1, 3), (5, 3, 4), (6, 4, 2)]
    assert [graph.curve(e).length for e in graph.edges] == pytest.approx([5 / 3] * 3)
    assert graph.vertex(3).label == '3/1'


def test_edges_that_are_short_enough_stay_as_they_are():
    graph = graph_of({1: (0, 0), 2: (2, 0), 3: (2, 4)}, {7: (1, 2), 3: (2, 3)})
    split = split_edges(graph, 2.0)
    assert split.edges[7] == graph.edges[7]
    assert sorted(split.edges) == [7, 8, 9]
    assert split.vertices[1] == graph.vertices[1]


def _turning_on_the_spot(ahead, behind):
    return Graph([Vertex(1, 0.0, 0.0, math.pi), Vertex(2, 2.558151373641067, 0.0, 0.0)],
                 [Edge(5, 1, 2, CurveType.SPLINE, ahead, behind, 0.4, 0.3)])


@given(splines, st.floats(0.5, 3.0))
@example(_turning_on_the_spot(1.0, 0.0), 1.0)
@example(_turning_on_the_spot(0.0, 1.0), 2.0)
@example(_turning_on_the_spot(0.8, 1e-8), 1.0)
def test_sections_lie_on_the_old_curve_and_keep_its_length_and_speeds(graph, longest):
    old, split = graph.curve(5), split_edges(graph, longest)
    lengths = [split.curve(e).length for e in split.edges]
    assert sum(lengths) == pytest.approx(old.length, rel=1e-6, abs=1e-4)  # cusps: 0.01 mm
    assert max(lengths) <= longest * (1 + 1e-6)
    assert max(lengths) - min(lengths) <= 1e-6 * old.length
    for id, edge in split.edges.items():
        assert (edge.velocity_forward, edge.velocity_backwards) == (0.4, 0.3)
        for x, y in split.curve(id).sample(0.3):
            assert old.project(x, y).distance <= 3e-4


@given(splines, st.floats(0.5, 3.0))
def test_a_split_graph_is_the_same_when_read_from_its_file(tmp_path_factory, graph, longest):
    file = tmp_path_factory.mktemp('split') / 'graph.yaml'
    split = split_edges(graph, longest)
    save_graph(split, file)
    read = load_graph(file)
    assert dict(read.vertices) == dict(split.vertices)
    assert dict(read.edges) == dict(split.edges)


def test_a_bend_stays_a_bend():
    split = split_edges(spline_graph(), 1.0)
    middle = split.vertices[3]
    assert middle.theta == pytest.approx(math.pi / 4, abs=0.4)
    headings = [split.curve(e).heading_at(1e9) for e in split.edges]
    assert headings == sorted(headings)
    assert np.ptp(headings) > 0.5


def test_the_command_writes_a_graph_and_says_what_it_did(tmp_path, capsys):
    old, new = tmp_path / 'old.yaml', tmp_path / 'new.yaml'
    save_graph(graph_of({1: (0, 0), 2: (5, 0)}, {3: (1, 2)}), old)
    assert split_edges_main(['--longest', '2', str(old), str(new)]) == 0
    assert len(load_graph(new).edges) == 3
    assert capsys.readouterr().out == f'{new}: 4 vertices and 3 edges; before: 2 and 1.\n'


@pytest.mark.parametrize('longest, file, sentence', [
    ('1e-9', 'old.yaml', 'choose a greater length'),
    ('2', 'none.yaml', 'the file cannot be read'),
    ('2', 'old.yaml/nowhere', 'cannot be'),
])
def test_what_the_command_cannot_do_is_one_sentence(tmp_path, capsys, longest, file, sentence):
    save_graph(graph_of({1: (0, 0), 2: (5, 0)}, {3: (1, 2)}), tmp_path / 'old.yaml')
    arguments = ['--longest', longest, str(tmp_path / file), str(tmp_path / 'out.yaml')]
    assert split_edges_main(arguments) == 1
    message = capsys.readouterr().err
    assert sentence in message
    assert message.count('\n') == 1


def test_a_file_that_cannot_be_written_is_named(tmp_path, capsys):
    save_graph(graph_of({1: (0, 0), 2: (5, 0)}, {3: (1, 2)}), tmp_path / 'old.yaml')
    out = str(tmp_path / 'no' / 'out.yaml')
    assert split_edges_main(['--longest', '2', str(tmp_path / 'old.yaml'), out]) == 1
    assert capsys.readouterr().err == f'{out} cannot be written: No such file or directory.\n'


def test_a_section_knows_the_edge_that_was_drawn_also_in_a_file_and_when_cut_again(tmp_path):
    drawn = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 6.0, 0.0, 0.0), Vertex(3, 7.0, 0.0, 0.0)],
                  [Edge(7, 1, 2), Edge(8, 2, 3)])
    save_graph(split_edges(split_edges(drawn, 3.0), 1.5), tmp_path / 'cut.yaml')
    graph = load_graph(tmp_path / 'cut.yaml')
    sections = {id for id, edge in graph.edges.items() if edge.drawn_id == 7}
    assert len(sections) == 4 and graph.edges[8].drawn_id == 8
    for id in (7, *sections):
        assert graph.whole_edges([id]) == graph.whole_edges([-id]) == sections
    assert graph.whole_edges([8, 99]) == {8, 99}, 'other ids stay as they are'
