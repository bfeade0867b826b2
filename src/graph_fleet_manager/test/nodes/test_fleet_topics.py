"""The messages of the supervisor are published in order."""
from __future__ import annotations

import genpy
import pytest
import rospy
from fleet_builders import AGV

from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.planning.tasks import Task
from fleet_core.supervision.actions import AskPlanner, PublishStatus
from fleet_core.supervision.missions import MissionState, Status
from graph_fleet_manager.nodes import fleet_topics
from itrci_nav_msgs.msg import PlanAnswer


class _Publisher:
    """Keeps published messages by topic. A message with the id 13 cannot be serialised."""

    sent: dict = {}
    error: Exception

    newcomers: dict = {}

    def __init__(self, topic, *_, subscriber_listener=None, **__):
        self._topic = topic
        self.newcomers[topic] = subscriber_listener

    def publish(self, message):
        if getattr(message, 'request_id', 0) == 13:
            raise self.error
        self.sent.setdefault(self._topic, []).append(message)


@pytest.fixture
def topics(monkeypatch):
    monkeypatch.setattr(fleet_topics.rospy, 'Publisher', _Publisher)
    monkeypatch.setattr(fleet_topics.rospy.Time, 'now', lambda: rospy.Time(5))
    monkeypatch.setattr(_Publisher, 'sent', {})
    return fleet_topics.FleetTopics(('r',), 1.0, 0.5, print, StopGate())


def test_a_question_to_the_planner_carries_its_seed(topics):
    topics.do([AskPlanner(3, (Task('r', AGV, 1),), (), frozenset(), {}, seed=7)])
    (message,) = _Publisher.sent['/plan_request']
    assert (message.plan_id, message.seed) == (3, 7)


def test_a_question_is_asked_again_with_all_times_where_the_planner_lacks_some(topics):
    times = {('agv', 1): 3.0}
    topics.do([AskPlanner(3, (), (), frozenset(), times)])
    assert topics.is_answered(answer_to(_Publisher.sent['/plan_request'][-1]))
    topics.do([AskPlanner(4, (), (), frozenset(), times)])
    assert [len(one.edge_times) for one in _Publisher.sent['/plan_request']] == [1, 0]
    lacking = answer_to(_Publisher.sent['/plan_request'][-1], PlanAnswer.OTHER_TIMES)
    assert not topics.is_answered(lacking)
    again = _Publisher.sent['/plan_request'][-1]
    assert (again.plan_id, again.edge_times_since, len(again.edge_times)) == (4, 0, 1)
    assert topics.is_answered(answer_to(again))


def test_a_planner_that_connects_late_gets_the_open_question_at_once(topics):
    heard = []
    planner_connects = _Publisher.newcomers['/plan_request'].peer_subscribe
    planner_connects('/plan_request', None, heard.append)
    assert not heard
    topics.do([AskPlanner(3, (), (), frozenset(), {})])
    planner_connects('/plan_request', None, heard.append)
    assert [question.plan_id for question in heard] == [3]
    assert topics.is_answered(answer_to(heard[0]))
    planner_connects('/plan_request', None, heard.append)
    assert len(heard) == 1


def test_an_answer_to_an_older_question_is_none(topics):
    topics.do([AskPlanner(3, (), (), frozenset(), {}), AskPlanner(4, (), (), frozenset(), {})])
    assert not topics.is_answered(answer_to(_Publisher.sent['/plan_request'][0]))


def answer_to(request, result=PlanAnswer.PLANNED):
    """Returns the planner's answer to this request."""
    answer = PlanAnswer(plan_id=request.plan_id, result=result)
    answer.header.stamp = request.header.stamp
    return answer


@pytest.mark.parametrize('error', [genpy.SerializationError('too late'),
                                   rospy.ROSSerializationException('too late')])
def test_a_message_that_cannot_be_serialised_is_logged_and_the_others_go_out(
        topics, monkeypatch, error):
    logged = []
    monkeypatch.setattr(fleet_topics.rospy, 'logerr', lambda text, *words: logged.append(
        text % words))
    monkeypatch.setattr(_Publisher, 'error', error, raising=False)
    topics.do([PublishStatus(Status(id, MissionState.PENDING)) for id in (12, 13, 14)])
    assert [status.request_id for status in _Publisher.sent['/mission_status']] == [12, 14]
    assert logged == ['A defect: a MissionStatus is not sent, because it cannot be serialised (too '
                      'late).']
