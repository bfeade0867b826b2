"""A click on a robot of a fleet requests one mission; its end is reported once."""
from __future__ import annotations

import time
from typing import Any, Dict, List, Optional, Tuple

import pytest
import rospy

from fleet_requests import SILENCE
from itrci_nav_msgs.msg import MissionRequest, MissionStatus
from itrci_nav_msgs.srv import GetMissionStatus, GetMissionStatusResponse
from omron_ld90.nodes.support.fleet_missions import FleetMissions
from omron_ld90.operator.goal_clicks import Target, TargetKind
from omron_ld90.operator.notices import NoticeSeverity, OperatorNotice


class Topics:
    """Replaces ROS: keeps the published messages, and knows which topics have subscribers."""

    def __init__(self) -> None:
        self.listeners = ['/fleet_page', '/path_supervisor']
        self.requests: List[MissionRequest] = []
        self.heard: Dict[str, Any] = {}

        self.stored: Optional[GetMissionStatusResponse] = None
        self.asked = 0

    def service(self, name: str, kind: type) -> Any:
        assert (name, kind) == ('/get_mission_status', GetMissionStatus)
        return self.ask

    def ask(self, request_id: int, stamp: rospy.Time) -> GetMissionStatusResponse:
        self.asked += 1
        if self.stored is None:
            raise rospy.ServiceException('it is being restarted')
        return self.stored

    def publisher(self, topic: str, kind: type, **_: Any) -> Topics:
        assert (topic, kind) == ('/mission_request', MissionRequest)
        return self

    @property
    def impl(self) -> Topics:
        return self

    def get_stats_info(self) -> List[Tuple[int, str]]:
        return list(enumerate(self.listeners))

    def publish(self, request: MissionRequest) -> None:
        self.requests.append(request)

    def subscribe(self, topic: str, kind: type, callback: Any, **_: Any) -> None:
        self.heard[topic] = callback

    def tell(self, request_id: int, state: int, reason: str = '') -> None:
        self.heard['/mission_status'](
            MissionStatus(request_id=request_id, state=state, reason=reason))


@pytest.fixture
def topics(monkeypatch) -> Topics:
    made = Topics()
    monkeypatch.setattr(rospy, 'Publisher', made.publisher)
    monkeypatch.setattr(rospy, 'Subscriber', made.subscribe)
    monkeypatch.setattr(rospy, 'ServiceProxy', made.service)
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time(5, 0))
    return made


@pytest.fixture
def told() -> List[Tuple[OperatorNotice, Any]]:
    return []


@pytest.fixture
def missions(topics, told) -> FleetMissions:
    return FleetMissions('omron_1', lambda notice, target: told.append((notice, target)))


TARGET = Target(TargetKind.GOAL, '12', 1.0, 2.0)


def test_a_click_is_a_mission_of_this_robot_to_that_vertex(topics, missions):
    notice = missions.send(TARGET)
    request, = topics.requests
    assert (request.robot, list(request.destination_vertices_id)) == ('omron_1', [12])
    assert request.header.stamp == rospy.Time(5, 0)
    assert notice == OperatorNotice(
        NoticeSeverity.INFO, f'omron_1 to vertex 12, as mission {request.request_id} ...')


def test_each_click_is_a_mission_of_its_own(topics, missions):
    missions.send(TARGET)
    missions.send(TARGET)
    first, second = topics.requests
    assert first.request_id != second.request_id
    assert min(first.request_id, second.request_id) > 0


def test_where_nobody_takes_missions_none_is_sent(topics, missions):
    topics.listeners = ['/fleet_page']
    notice = missions.send(TARGET)
    assert topics.requests == []
    assert notice == OperatorNotice(
        NoticeSeverity.BAD, 'Not sent. No program takes missions: is path_supervisor running?')


@pytest.mark.parametrize(('state', 'reason', 'severity', 'words'), [
    (MissionStatus.SUCCEEDED, '', NoticeSeverity.GOOD, 'has succeeded'),
    (MissionStatus.FAILED, 'no way', NoticeSeverity.BAD, 'has failed: no way'),
    (MissionStatus.REFUSED, 'no such vertex', NoticeSeverity.BAD, 'was refused: no such vertex'),
    (MissionStatus.CANCELLED, '', NoticeSeverity.INFO, 'was cancelled'),
    (MissionStatus.EXPIRED, 'too late', NoticeSeverity.BAD, 'has expired: too late')])
def test_the_end_of_a_mission_is_told_once(topics, missions, told, state, reason, severity, words):
    missions.send(TARGET)
    id = topics.requests[0].request_id
    topics.tell(id, state, reason)
    topics.tell(id, state, reason)
    assert told == [(OperatorNotice(severity, f'Mission {id} {words}'), TARGET)]


@pytest.mark.parametrize('state', [
    value for name, value in vars(MissionStatus).items() if name.isupper() and name not in (
        'SUCCEEDED', 'FAILED', 'REFUSED', 'CANCELLED', 'EXPIRED')
    and not name.startswith(('COMMAND_', 'DEADLINE_'))])
def test_what_comes_before_the_end_is_not_told(topics, missions, told, state):
    missions.send(TARGET)
    id = topics.requests[0].request_id
    topics.tell(id, state)
    assert told == []
    topics.tell(id, MissionStatus.SUCCEEDED)
    assert len(told) == 1


def test_missions_of_others_are_not_told(topics, missions, told):
    missions.send(TARGET)
    topics.tell(topics.requests[0].request_id + 1, MissionStatus.FAILED)
    assert told == []


def test_an_end_that_was_missed_is_asked_for(topics, missions, told, monkeypatch):
    now = 100.0
    monkeypatch.setattr(time, 'monotonic', lambda: now)
    missions.send(TARGET)
    id = topics.requests[0].request_id
    missions.ask()
    assert topics.asked == 0, 'a message arrived a moment ago'
    now += 2 * SILENCE
    missions.ask()
    assert told == [], 'the fleet manager does not answer yet'
    topics.stored = GetMissionStatusResponse(
        True, MissionStatus(request_id=id, state=MissionStatus.SUCCEEDED))
    missions.ask()
    missions.ask()
    assert told == [(OperatorNotice(NoticeSeverity.GOOD, f'Mission {id} has succeeded'), TARGET)]


def test_a_click_that_the_fleet_manager_never_got_is_told(topics, missions, told, monkeypatch):
    now = 100.0
    monkeypatch.setattr(time, 'monotonic', lambda: now)
    missions.send(TARGET)
    now += 2 * SILENCE
    topics.stored = GetMissionStatusResponse()
    missions.ask()
    (notice, target), = told
    assert (notice.severity, target) == (NoticeSeverity.BAD, TARGET)
    assert 'has not reached the fleet manager' in notice.text
