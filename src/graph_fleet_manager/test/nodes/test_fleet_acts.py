"""The requests of the robot's menu in RViz to the fleet manager."""
from __future__ import annotations

import queue
from typing import Any, List, Tuple

import pytest
import rospy
from std_srvs.srv import Trigger, TriggerResponse

from graph_fleet_manager.commands.fleet_client import requested_by
from graph_fleet_manager.nodes import fleet_acts
from graph_fleet_manager.nodes.rviz.menus import EDGE_MENU, ROBOT_MENU, MenuAct, Subject
from itrci_nav_msgs.msg import EdgeCommand
from itrci_nav_msgs.srv import DeclareAbsent, DeclareAbsentResponse


@pytest.mark.parametrize('act, service, kind', [
    (MenuAct.ABSENT, '/a/declare_absent', DeclareAbsent), (MenuAct.OUT, '/a/leave_fleet', Trigger),
    (MenuAct.IN, '/a/join_fleet', Trigger)])
def test_a_choice_in_the_robots_menu_calls_its_service(monkeypatch, act, service, kind):
    called, said = [], queue.Queue()
    monkeypatch.setattr(rospy, 'Publisher', lambda *_, **__: None)
    monkeypatch.setattr(rospy, 'wait_for_service', lambda *_: None)

    def proxy(*of, headers):
        called.append((*of, headers['requested_by']))
        return lambda: DeclareAbsentResponse(True, 'a: done.')
    monkeypatch.setattr(rospy, 'ServiceProxy', proxy)
    fleet_acts.FleetActs(said.put).act(act, Subject(robot='a'))
    assert said.get(timeout=10.0) == 'a: done.'
    assert called == [(service, kind, requested_by('RViz'))] and act in ROBOT_MENU


@pytest.mark.parametrize('answer, expected', [
    (TriggerResponse(True, 'The fleet goes on, except b: emergency stop.'),
     'The fleet goes on, except b: emergency stop.'),
    (TriggerResponse(False, 'the fleet was stopped again meanwhile'),
     f'{MenuAct.RESUME_ALL.value}: NOT DONE: the fleet was stopped again meanwhile')])
def test_only_what_is_not_done_is_told_as_not_done(monkeypatch, answer, expected):
    said = queue.Queue()
    monkeypatch.setattr(rospy, 'Publisher', lambda *_, **__: None)
    monkeypatch.setattr(rospy, 'wait_for_service', lambda *_: None)
    monkeypatch.setattr(rospy, 'ServiceProxy', lambda *_, **__: lambda: answer)
    fleet_acts.FleetActs(said.put).act(MenuAct.RESUME_ALL, Subject())
    assert said.get(timeout=10.0) == expected


class Publisher:
    """Keeps the published messages; these nodes subscribe to it."""

    def __init__(self, *subscribers: str) -> None:
        self.sent: List[Any] = []
        self.subscribers = subscribers

    def publish(self, message: Any) -> None:
        self.sent.append(message)

    @property
    def impl(self) -> Publisher:
        return self

    def get_stats_info(self) -> List[Tuple[int, str]]:
        return list(enumerate(self.subscribers))


def menu(monkeypatch, publisher: Publisher, said: List[str], *closed: int) -> fleet_acts.FleetActs:
    monkeypatch.setattr(rospy, 'Publisher', lambda *_, **__: publisher)
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time(5))
    acts = fleet_acts.FleetActs(said.append)
    acts.closed = frozenset(closed)
    return acts


@pytest.mark.parametrize('act, code, edges', [
    (MenuAct.CLOSE, EdgeCommand.CLOSE, [3]), (MenuAct.OPEN, EdgeCommand.OPEN, [3]),
    (MenuAct.OPEN_ALL, EdgeCommand.OPEN, [3, 4])])
def test_a_choice_in_the_menu_of_an_edge_is_an_operation_on_edges(monkeypatch, act, code, edges):
    publisher, said = Publisher('/graph_server'), []
    menu(monkeypatch, publisher, said, 3, 4).act(act, Subject(edge=3))
    sent, = publisher.sent
    assert (sent.command, list(sent.edges), sent.header.stamp) == (code, edges, rospy.Time(5))
    assert sent.requested_by and act in EDGE_MENU and said


def test_without_closed_edges_or_graph_server_the_menu_says_so(monkeypatch):
    said = []
    menu(monkeypatch, Publisher('/graph_server'), said).act(MenuAct.OPEN_ALL, Subject(edge=3))
    menu(monkeypatch, Publisher('/fleet_page'), said).act(MenuAct.CLOSE, Subject(edge=3))
    assert said == ['No edge is closed',
                    'No program takes commands for edges: is graph_server running?']
