"""Each message is stamped once. If no program receives or carries out a message, this is reported.
"""
from __future__ import annotations

import time
from typing import Any, List, Tuple

import pytest
import rospy
from std_srvs.srv import TriggerResponse

from fleet_requests import (
    SILENCE,
    ImpossibleRequest,
    MissionNews,
    NotSent,
    Sender,
    ServiceRefused,
    ServiceSilent,
    call,
    mission_request,
    stored_status,
)
from itrci_nav_msgs.msg import DeviceRequest, EdgeCommand, MissionCommand, MissionRequest
from itrci_nav_msgs.srv import GetMissionStatusResponse


class Topic:
    """A publisher that keeps the stamps of its messages and is connected to these nodes."""

    listeners: Tuple[str, ...] = ('/path_supervisor', '/graph_server', '/fleet_page')

    def __init__(self, *_: Any, **__: Any) -> None:
        self.stamps: List[rospy.Time] = []

    def publish(self, message: Any) -> None:
        self.stamps.append(message.header.stamp)

    @property
    def impl(self) -> Topic:
        return self

    def get_stats_info(self) -> List[Tuple[int, str]]:
        return list(enumerate(self.listeners))


@pytest.fixture(autouse=True)
def topics(monkeypatch):
    clock = iter(map(rospy.Time, range(5, 100)))
    monkeypatch.setattr(rospy, 'Publisher', Topic)
    monkeypatch.setattr(rospy.Time, 'now', lambda: next(clock))


@pytest.mark.parametrize('kind', [MissionRequest, MissionCommand, EdgeCommand])
def test_a_message_is_stamped_when_it_is_sent(kind):
    sender = Sender(kind)
    sender.send(kind())
    sender.send(kind())
    assert sender._publisher.stamps == [rospy.Time(5), rospy.Time(6)]


def test_a_repeated_request_keeps_its_stamp_by_which_it_is_known():
    requests, request = Sender(MissionRequest), mission_request([3])
    requests.send(request)
    requests.repeat(request)
    assert requests._publisher.stamps == [rospy.Time(5)] * 2


RECEIVERS = {MissionRequest: 'path_supervisor', MissionCommand: 'path_supervisor',
             EdgeCommand: 'graph_server', DeviceRequest: 'fleet_devices'}


@pytest.mark.parametrize('kind, node', RECEIVERS.items())
@pytest.mark.parametrize('others', [(), ('/fleet_page', '/record_1'), ('/not_path_supervisor',)])
def test_what_its_receiver_does_not_hear_is_not_sent_whoever_else_listens(
        monkeypatch, kind, node, others):
    monkeypatch.setattr(Topic, 'listeners', (*others, *(
        f'/{other}' for other in RECEIVERS.values() if other != node)))
    sender = Sender(kind)
    with pytest.raises(NotSent, match=node):
        sender.send(kind())
    assert sender._publisher.stamps == [] and not sender.is_heard


@pytest.mark.parametrize('kind, node', RECEIVERS.items())
@pytest.mark.parametrize('namespace', ['/', '/site/'])
def test_a_receiver_that_listens_is_known_by_its_name(monkeypatch, kind, node, namespace):
    monkeypatch.setattr(Topic, 'listeners', ('/fleet_page', namespace + node))
    assert Sender(kind).is_heard


def test_a_request_that_names_a_group_has_stops_at_which_nothing_is_done():
    request = mission_request([18, 'shelves'], request_id=7, priority=2)
    assert [(stop.vertex, stop.group, stop.steps) for stop in request.stops] == [
        (18, '', []), (0, 'shelves', [])]
    assert (list(request.destination_vertices_id), request.request_id, request.priority) == (
        [], 7, 2)
    with pytest.raises(ImpossibleRequest, match='A group takes no stay'):
        mission_request(['shelves'], dwell=[3.0])


def test_each_request_has_an_id_of_its_own_unless_one_is_given():
    first, second = mission_request([1, 2], robot='a'), mission_request([1, 2])
    assert first.request_id != second.request_id and min(first.request_id, second.request_id) > 0
    assert (first.destination_vertices_id, first.robot) == ([1, 2], 'a')
    assert mission_request([1], request_id=7).request_id == 7


def service(monkeypatch, answer: Any) -> List[Any]:
    """Makes all services give this answer, or raise it. Returns the arguments of the calls."""
    asked: List[Any] = []

    def ask(*arguments: Any) -> Any:
        asked.append(arguments)
        if isinstance(answer, Exception):
            raise answer
        return answer
    monkeypatch.setattr(rospy, 'wait_for_service', lambda *_: None)
    monkeypatch.setattr(rospy, 'ServiceProxy', lambda *_, **__: ask)
    return asked


def test_a_fleet_manager_that_restarts_has_no_stored_status_yet(monkeypatch):
    service(monkeypatch, rospy.ServiceException('gone'))
    assert stored_status(7) is None


def test_the_stored_status_of_any_stamp_is_asked_for_with_zero(monkeypatch):
    asked = service(monkeypatch, GetMissionStatusResponse(found=True))
    assert stored_status(7).found and stored_status(7, rospy.Time(3)).found
    assert asked == [(7, rospy.Time()), (7, rospy.Time(3))]


def test_a_service_that_did_it_gives_its_message(monkeypatch):
    asked = service(monkeypatch, TriggerResponse(True, 'a: done'))
    assert call('/a/leave_fleet') == 'a: done'
    assert asked == [()]


@pytest.mark.parametrize('answer, error, words', [
    (TriggerResponse(False, 'it stands in the way'), ServiceRefused, '^it stands in the way$'),
    (rospy.ServiceException('gone'), ServiceSilent, r'^/a/leave_fleet does not answer \(gone\)$'),
    (rospy.ROSException('late'), ServiceSilent, r'does not answer \(late\)$')])
def test_a_service_that_did_not_do_it_says_why(monkeypatch, answer, error, words):
    service(monkeypatch, answer)
    with pytest.raises(error, match=words):
        call('/a/leave_fleet')


def test_a_mission_is_silent_until_there_is_news_of_it_or_its_end(monkeypatch):
    now = 100.0
    monkeypatch.setattr(time, 'monotonic', lambda: now)
    news = MissionNews()
    for id in (3, 5):
        news.heard(id)
    now += SILENCE / 2
    news.heard(5)
    assert news.silent() == []
    now += SILENCE / 2
    assert news.silent() == [3]
    news.heard(3)
    assert news.silent() == [] and 3 in news
    now += SILENCE
    news.ended(5)
    assert news.silent() == [3] and 5 not in news
