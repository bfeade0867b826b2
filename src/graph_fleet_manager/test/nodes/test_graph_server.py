"""graph_server surveys each graph. A command that closes a section closes the whole drawn edge."""
from __future__ import annotations

import os
import threading
from types import SimpleNamespace
from typing import List
from unittest.mock import MagicMock

import pytest
import rospy
from fleet_builders import AGV, corridor

from fleet_core.fleet import Fleet
from fleet_core.site.closures import Closures
from graph_fleet_manager.commands.command_line import CommandProblem
from graph_fleet_manager.commands.edge import asked_edges
from graph_fleet_manager.nodes import edge_closures
from graph_fleet_manager.nodes.edge_closures import EdgeClosures
from graph_fleet_manager.nodes.graph_server import GraphServer
from graph_fleet_manager.nodes.rviz import menus
from graph_fleet_manager.nodes.rviz.menus import FleetMenus
from itrci_nav_msgs.msg import ClosedEdges, EdgeCommand, ParkingPlaces
from trajectory_graph import Edge, Graph, Vertex, split_edges

# -- the survey, also of a hardened service that may not change a priority -------------------------

def test_a_graph_is_surveyed_although_the_priority_may_not_be_changed(
        monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: int) -> None:
        raise PermissionError
    published: List[ParkingPlaces] = []
    server = object.__new__(GraphServer)
    server._fleet, server._lock = Fleet((AGV,), (), 0.1), threading.RLock()
    server._stamp, server._parked_with = rospy.Time(1), frozenset()
    server._closures = SimpleNamespace(edges=frozenset())
    server._parking = SimpleNamespace(publish=published.append)
    monkeypatch.setattr(os, 'setpriority', refuse)
    server._survey(corridor(4), server._stamp)
    assert len(published) == 1 and published[0].vertices


# -- closing sections ------------------------------------------------------------------------------

@pytest.fixture
def graph() -> Graph:
    """Returns a graph with edge 7 in three sections, 9 to 11, and with the short edge 8."""
    drawn = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 6.0, 0.0, 0.0), Vertex(3, 7.0, 0.0, 0.0)],
                  [Edge(7, 1, 2), Edge(8, 2, 3)])
    return split_edges(drawn, 2.0)


@pytest.fixture
def closures(tmp_path, monkeypatch, graph) -> EdgeClosures:
    monkeypatch.setattr(edge_closures.rospy, 'Publisher',
                        lambda *_, **__: SimpleNamespace(publish=lambda message: None))
    monkeypatch.setattr(edge_closures.rospy.Time, 'now',
                        staticmethod(lambda: SimpleNamespace(to_nsec=lambda: 10 ** 18)))
    return EdgeClosures(Closures(tmp_path / 'closed.json'), threading.RLock(),
                        lambda: graph, lambda: None)


def command(action: int, *edges: int) -> EdgeCommand:
    message = EdgeCommand(command=action, edges=edges)
    message._connection_header = {'callerid': '/person'}
    return message


@pytest.mark.parametrize('clicked', [7, 9, 10, 11, -10])
def test_one_click_closes_and_opens_the_whole_edge(closures, clicked):
    closures._on_command(command(EdgeCommand.CLOSE, abs(clicked)))
    assert closures.edges == {9, 10, 11}
    closures._on_command(command(EdgeCommand.OPEN, abs(clicked)))
    assert closures.edges == frozenset()


def test_a_list_of_closed_edges_may_name_drawn_edges(closures):
    closures._on_list(ClosedEdges(edges=[7, 8]))
    assert closures.edges == {8, 9, 10, 11}


def test_an_edge_that_was_not_cut_is_closed_alone(closures):
    closures._on_command(command(EdgeCommand.CLOSE, 8))
    assert closures.edges == {8}


def test_the_log_names_the_drawn_edges(closures, monkeypatch):
    said = []
    monkeypatch.setattr(edge_closures.rospy, 'loginfo', lambda text, *of: said.append(text % of))
    closures._on_command(command(EdgeCommand.CLOSE, 8, 10))
    assert said == ["'/person' closes edges: 7, 8.", 'Closed edges: 7, 8.']


def test_the_command_edge_takes_drawn_edges(graph):
    assert asked_edges(graph, [7]) == asked_edges(graph, [-10]) == [9, 10, 11]
    with pytest.raises(CommandProblem, match='no edge 12'):
        asked_edges(graph, [8, 12])


def test_the_menu_of_a_section_is_about_the_drawn_edge(graph, monkeypatch):
    subjects = {}
    monkeypatch.setattr(menus, 'OrderedMarkerServer', MagicMock())
    monkeypatch.setattr(menus, 'MenuHandler', MagicMock())
    monkeypatch.setattr(FleetMenus, '_insert', lambda self, name, place, shapes, menu, subject, *_:
                        subjects.__setitem__(name, subject))
    FleetMenus(lambda *_: None).show_graph(graph)
    assert {subject.edge for subject in subjects.values()} == {0, 7, 8}
