"""A graph in force stays in force while robots drive on it, also after restarts."""
from __future__ import annotations

import pytest
from fleet_builders import corridor

from fleet_core.site.changes import ReportedRoute
from fleet_core.site.graph_in_force import GraphInForce, Loaded
from trajectory_graph import save_graph

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
        # the robot may have been carried there meanwhile
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
