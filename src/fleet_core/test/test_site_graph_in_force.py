"""A graph in force stays in force while robots drive on it, even after restarts."""
from __future__ import annotations

from dataclasses import replace

import pytest
from fleet_builders import corridor

from fleet_core.site.changes import ReportedRoute, what_breaks
from fleet_core.site.graph_in_force import GraphInForce, Loaded
from trajectory_graph import Graph, save_graph

LONG, SHORT = corridor(4), corridor(3)  # the short graph lacks edge 3


@pytest.fixture
def file(tmp_path):
    path = str(tmp_path / 'graph.yaml')
    save_graph(LONG, path)
    return path


@pytest.fixture
def copy(tmp_path):
    return str(tmp_path / 'state' / 'copy.yaml')


def running(copy, file):
    """A server on which the long graph is in force."""
    server = GraphInForce(copy)
    assert server.load(file) == Loaded(True, '')
    return server


def test_a_valid_file_is_in_force_and_read_again_is_no_change(copy, file):
    server = running(copy, file)
    assert server.graph.edges == LONG.edges
    assert server.load(file) == Loaded(False, '')


def test_what_is_no_graph_is_refused_and_the_old_one_stays(copy, file):
    server = running(copy, file)
    with open(file, 'w', encoding='utf-8') as stream:
        stream.write('nonsense')
    changed, trouble = server.load(file)
    assert (changed, len(server.graph.edges)) == (False, 3)
    assert file in trouble


def test_a_running_route_is_not_broken_but_a_driven_one_may_be(copy, file):
    server = running(copy, file)
    save_graph(SHORT, file)
    server.routes['agv_1'] = ReportedRoute((2, 3), 1)
    changed, trouble = server.load(file)
    assert not changed
    assert 'Edge 3 is missing, but robot agv_1' in trouble
    server.routes['agv_1'] = ReportedRoute((), 2)
    assert server.load(file) == Loaded(True, '')
    assert server.graph.edges == SHORT.edges


class TestAfterARestart:
    def test_an_unchanged_file_is_in_force_at_once(self, copy, file):
        running(copy, file)
        assert not GraphInForce(copy).must_hear_robots(file)

    def test_a_file_that_was_never_in_force_is_so_at_once(self, copy, file, tmp_path):
        running(copy, file)
        other = str(tmp_path / 'other.yaml')
        save_graph(SHORT, other)
        assert not GraphInForce(copy).must_hear_robots(other)
        assert not GraphInForce(str(tmp_path / 'nothing.yaml')).must_hear_robots(file)

    @pytest.mark.parametrize('text', [None, 'nonsense'], ids=['other graph', 'no graph'])
    def test_what_robots_drive_on_is_in_force_whatever_the_file_says(self, copy, file, text):
        running(copy, file)
        save_graph(SHORT, file)
        if text is not None:
            with open(file, 'w', encoding='utf-8') as stream:
                stream.write(text)
        again = GraphInForce(copy)
        assert again.must_hear_robots(file)
        again.routes['agv_1'] = ReportedRoute((3,), 2)
        changed, trouble = again.load(file)
        assert (changed, again.graph.edges) == (True, LONG.edges)
        assert trouble

    def test_the_file_is_in_force_where_nobody_drives(self, copy, file):
        running(copy, file)
        save_graph(SHORT, file)
        again = GraphInForce(copy)
        # the robot may have been carried there before the restart
        again.routes['agv_1'] = ReportedRoute((), 3)
        assert again.load(file) == Loaded(True, '')
        assert again.graph.edges == SHORT.edges

    def test_a_file_that_is_no_graph_leaves_none_in_force_where_nobody_drives(self, copy, file):
        running(copy, file)
        with open(file, 'w', encoding='utf-8') as stream:
            stream.write('nonsense')
        again = GraphInForce(copy)
        changed, trouble = again.load(file)
        assert (changed, again.graph) == (False, None)
        assert file in trouble


def test_a_graph_that_cannot_be_kept_is_not_in_force(file, tmp_path):
    (tmp_path / 'state').write_text('a file in the way of the folder')
    server = GraphInForce(str(tmp_path / 'state' / 'copy.yaml'))
    changed, trouble = server.load(file)
    assert (changed, server.graph) == (False, None)
    assert 'cannot be written' in trouble


# -- a new graph is refused if it lacks edges on which robots drive --------------------------------

OLD = corridor(4)
ROUTES = {'idle': ReportedRoute(), 'agv_1': ReportedRoute(left=(2, 3), edge=1)}


def changed(edges=(), vertices=(), without=()):
    """The corridor with some elements replaced or removed."""
    new_edges = {**OLD.edges, **{edge.id: edge for edge in edges}}
    new_vertices = {**OLD.vertices, **{vertex.id: vertex for vertex in vertices}}
    return Graph([v for v in new_vertices.values() if v.id not in without],
                 [e for e in new_edges.values()
                  if e.id not in without and not {e.origin, e.destination} & set(without)])


def moved(vertex, **by):
    return replace(OLD.vertices[vertex], **by)


def edge(id, **by):
    return replace(OLD.edges[id], **by)


@pytest.mark.parametrize('new', [
    OLD,
    changed(edges=[edge(1, velocity_backwards=0.0, velocity_forward=0.2)]),
    changed(edges=[edge(3, velocity_backwards=0.0)]),
    changed(vertices=[moved(1, label='a new name', parking=True)]),
], ids=['the same', 'another speed', 'one way, the other one', 'another name'])
def test_what_routes_do_not_need_may_change(new):
    assert what_breaks(OLD, new, ROUTES) is None


@pytest.mark.parametrize('new, words', [
    (changed(without=[4]), 'Edge 3 is missing, but robot agv_1 is to drive it'),
    (changed(vertices=[moved(4, x=7.0)]), 'Edge 3 runs elsewhere'),
    (changed(edges=[edge(2, origin=3, destination=2)]),
     'Edge 2 joins vertex 3 and vertex 2 and no longer vertex 2'),
    (changed(edges=[edge(3, velocity_forward=0.0)]), 'Edge 3 may not be driven forwards any more'),
    (changed(vertices=[moved(4, dock=True)]), 'Edge 3 ends at vertex 4, which is a dock now'),
    (changed(vertices=[moved(1, x=-1.0)]), 'Edge 1 runs elsewhere, but robot agv_1 is on it'),
])
def test_what_a_route_needs_may_not(new, words):
    assert words in what_breaks(OLD, new, ROUTES)


def test_without_robots_everything_may_change():
    assert what_breaks(OLD, changed(without=[4]), {'gone': ReportedRoute()}) is None


def test_an_edge_that_nobody_knew_breaks_nothing():
    assert what_breaks(OLD, OLD, {'agv_1': ReportedRoute((99,), 98)}) is None
