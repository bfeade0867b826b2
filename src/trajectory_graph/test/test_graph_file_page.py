"""docs/reference/graph_file.md describes the file that is read: keys, example, formula."""
from __future__ import annotations

import math
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from trajectory_graph import CurveType, Edge, Graph, GraphError, Vertex, load_graph
from trajectory_graph.yaml_file import edge_fields, vertex_fields

PAGE = (Path(__file__).resolve().parents[3] / 'docs/reference/graph_file.md').read_text()
KEYS = {key: required for keys, required in re.findall(
    r'^\| ((?:`\w+`(?:, )?)+) \|[^|]*\| ([^|;]*?)(?:;[^|]*)? \|', PAGE, re.MULTILINE)
    for key in re.findall(r'`(\w+)`', keys)}


def example(name: str) -> str:
    return re.search(rf'```{name}\n(.*?)```', PAGE, re.DOTALL).group(1)


def test_the_page_names_each_key_that_is_written():
    vertex = Vertex(1, 0.0, 0.0, 0.0, dock=True, parking=True)
    assert set(KEYS) == {*vertex_fields(vertex), *edge_fields(Edge(1, 1, 2))}


def test_the_smallest_graph_of_the_page_is_read(tmp_path):
    (tmp_path / 'graph.yaml').write_text(example('yaml'))
    graph = load_graph(tmp_path / 'graph.yaml')
    assert (len(graph.vertices), len(graph.edges)) == (2, 1)


def test_in_the_larger_graph_of_the_page_each_end_vertex_has_the_direction_of_its_edge(tmp_path):
    (tmp_path / 'graph.yaml').write_text(re.findall(r'```yaml\n(.*?)```', PAGE, re.DOTALL)[1])
    graph = load_graph(tmp_path / 'graph.yaml')
    ends = [vertex for vertex in graph.vertices.values() if graph.is_end_vertex(vertex.id)]
    assert sorted((vertex.id, vertex.dock, vertex.parking) for vertex in ends) == [
        (6, False, True), (7, True, None)]
    for vertex in ends:
        edge, = graph.edges_from(vertex.id)
        before, after = graph.curve(abs(edge)).points[-2:]
        assert edge < 0, 'the edge leads to the vertex'
        turn = math.atan2(*(after - before)[::-1]) - vertex.theta
        assert math.cos(turn) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize('key', sorted(KEYS))
def test_a_key_is_required_exactly_if_the_page_says_so(tmp_path, key):
    graph = {
        'Edges': [{'Id': 1, 'Origin_ID': 1, 'Destination_ID': 2, 'CurveType': 'spline',
                   'ParamF': 1.0, 'ParamB': 1.0, 'VelocityForward': 1.0, 'VelocityBackwards': 1.0}],
        'Vertices': [{'Id': id, 'X': 4.0 * id, 'Y': 0.0, 'Theta': 0.0, 'ThetaHolomonic': 0.0,
                      'Label': 'a', 'FrameId': 'map', 'Dock': 'false', 'Parking': 'true'}
                     for id in (1, 2)]}
    lines = []
    for section, entries in graph.items():
        lines.append(f'{section}:')
        lines += ['- {' + ', '.join(f'{name}: {value}' for name, value in entry.items()
                                    if name != key) + '}' for entry in entries]
    (tmp_path / 'graph.yaml').write_text('\n'.join(lines))
    if KEYS[key].startswith('no'):
        load_graph(tmp_path / 'graph.yaml')
    else:
        with pytest.raises(GraphError, match=f'{key} is missing'):
            load_graph(tmp_path / 'graph.yaml')


def test_a_spline_is_the_curve_of_the_page():
    one, other = Vertex(1, 1.0, 2.0, 0.7), Vertex(2, 5.0, 3.5, -0.4)
    edge = Edge(1, 1, 2, CurveType.SPLINE, 1.5, 0.8)
    p0, p3 = np.array(one.position), np.array(other.position)
    p1 = p0 + 1.5 * np.array((math.cos(0.7), math.sin(0.7)))
    p2 = p3 - 0.8 * np.array((math.cos(-0.4), math.sin(-0.4)))
    curve = Graph([one, other], [edge]).curve(1)
    for t in np.linspace(0.0, 1.0, 21):
        x, y = ((1 - t) ** 3 * p0 + 3 * (1 - t) ** 2 * t * p1 + 3 * (1 - t) * t ** 2 * p2
                + t ** 3 * p3)
        assert curve.project(x, y).distance < 1e-4


def test_the_python_lines_of_the_page_write_that_graph(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'graph_file.py').write_text(example('python'))
    runpy.run_path('graph_file.py')
    (tmp_path / 'page.yaml').write_text(example('yaml'))
    assert load_graph('graph.yaml').is_same(load_graph('page.yaml'))
