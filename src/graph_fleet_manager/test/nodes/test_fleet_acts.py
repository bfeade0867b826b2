"""The requests of the robot's menu in RViz to the fleet manager."""
from __future__ import annotations

import queue
from typing import Any, Dict, List, Optional, Tuple

import pytest
import rospy
from std_srvs.srv import Trigger, TriggerResponse
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

from fleet_core.supervision.missions import MissionState
from graph_fleet_manager.commands.fleet_client import requested_by
from graph_fleet_manager.nodes import fleet_acts
from graph_fleet_manager.nodes.rviz import menus
from graph_fleet_manager.nodes.rviz.menus import (
    ANSWERS,
    EDGE_MENU,
    ROBOT_MENU,
    Ask,
    MenuAct,
    Subject,
)
from graph_fleet_manager.nodes.rviz.robot_picture import DrawnPose
from itrci_nav_msgs.msg import EdgeCommand, FleetRobot, MissionCommand, MissionStatus
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
    """A topic that keeps the published messages; the given nodes subscribe to it."""

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


def asking(state: MissionState, key: int, id: int = 7) -> MissionStatus:
    return MissionStatus(request_id=id, state=int(state), asks=key)


@pytest.mark.parametrize('act, answer', [
    (MenuAct.RETRY, MissionCommand.RETRY), (MenuAct.SKIP, MissionCommand.SKIP),
    (MenuAct.DONE, MissionCommand.DONE), (MenuAct.FAIL, MissionCommand.FAIL)])
def test_a_step_is_answered_in_the_menu_of_the_robot(monkeypatch, act, answer):
    publisher, said = Publisher('/path_supervisor'), []
    acts = menu(monkeypatch, publisher, said)
    acts.robots = {'a': FleetRobot(name='a', has_mission=True, request_id=7),
                   'b': FleetRobot(name='b', has_mission=True, request_id=8)}
    acts.mission_said(asking(MissionState.NEEDS_PERSON, 2 ** 52))
    assert acts.asks() == {'a': Ask(2 ** 52, ANSWERS)}
    acts.act(act, Subject(robot='a', step=acts.asks()['a'].step))
    sent, = publisher.sent
    assert (sent.command, sent.request_id, sent.answer, sent.step_key) == (
        MissionCommand.ANSWER, 7, answer, 2 ** 52)
    assert sent.requested_by and said == [f'{act.value}: a, mission 7']


def test_a_step_that_waits_for_a_person_cannot_be_done_again(monkeypatch):
    acts = menu(monkeypatch, Publisher('/path_supervisor'), [])
    acts.robots = {'a': FleetRobot(name='a', has_mission=True, request_id=7)}
    acts.mission_said(asking(MissionState.ACTIVE, 5))
    assert MenuAct.RETRY not in acts.asks()['a'].answers


@pytest.mark.parametrize('after', [
    asking(MissionState.ACTIVE, 0), asking(MissionState.CANCELLED, 5)])
def test_nothing_asks_after_the_answer_or_the_end_of_the_mission(monkeypatch, after):
    acts = menu(monkeypatch, Publisher('/path_supervisor'), [])
    acts.robots = {'a': FleetRobot(name='a', has_mission=True, request_id=7)}
    acts.mission_said(asking(MissionState.NEEDS_PERSON, 5))
    acts.mission_said(after)
    assert acts.asks() == {}


class MarkerServer:
    """Keeps the markers that RViz would show."""

    def __init__(self, *_: Any, **__: Any) -> None:
        self.markers: Dict[str, InteractiveMarker] = {}

    def insert(self, marker: InteractiveMarker, *_: Any) -> None:
        self.markers[marker.name] = marker

    def get(self, name: str) -> Optional[InteractiveMarker]:
        return self.markers.get(name)

    def erase(self, name: str) -> None:
        del self.markers[name]

    def applyChanges(self) -> None:  # noqa: N802, the name is the library's
        pass


def test_the_menu_of_a_robot_has_answers_while_its_step_asks(monkeypatch):
    monkeypatch.setattr(menus, 'OrderedMarkerServer', MarkerServer)
    chosen: List[Tuple[MenuAct, Subject]] = []
    shown = menus.FleetMenus(lambda *choice: chosen.append(choice))
    here = {'a': DrawnPose(1.0, 2.0, 0.0)}

    def titles() -> Dict[str, int]:
        entries = shown._server.get('robot a').menu_entries
        return {entry.title: entry.id for entry in entries}

    shown.show_robots(here, {})
    assert titles().keys() == {act.value for act in ROBOT_MENU}
    shown.show_robots(here, {'a': Ask(5, ANSWERS)})
    assert titles().keys() == {*(act.value for act in (*ROBOT_MENU, *ANSWERS)), menus.ANSWER}
    before = titles()[MenuAct.RETRY.value]
    shown.show_robots(here, {'a': Ask(9, ANSWERS[1:])})
    assert MenuAct.RETRY.value not in titles()
    for entry in (before, titles()[MenuAct.SKIP.value]):  # `before`: from a menu opened earlier
        shown._menus['robot a'].processFeedback(InteractiveMarkerFeedback(menu_entry_id=entry))
    assert chosen == [(MenuAct.RETRY, Subject(robot='a', step=5)),
                      (MenuAct.SKIP, Subject(robot='a', step=9))]
    shown.show_robots(here, {})
    assert menus.ANSWER not in titles()
    shown.show_robots({}, {})
    assert shown._server.markers == {}


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
