"""What the supervisor wants told goes out as it said."""
from __future__ import annotations

import rospy
from fleet_builders import AGV

from graph_fleet_manager.interlocking.stop_gate import StopGate
from graph_fleet_manager.nodes import fleet_topics
from graph_fleet_manager.planning.tasks import Task
from graph_fleet_manager.supervision.actions import AskPlanner


class _Publisher:
    """Keeps what is published, by topic."""

    sent: dict = {}

    def __init__(self, topic, *_, **__):
        self._topic = topic

    def publish(self, message):
        self.sent.setdefault(self._topic, []).append(message)


def test_a_question_to_the_planner_carries_its_seed(monkeypatch):
    monkeypatch.setattr(fleet_topics.rospy, 'Publisher', _Publisher)
    monkeypatch.setattr(fleet_topics.rospy.Time, 'now', lambda: rospy.Time(5))
    monkeypatch.setattr(_Publisher, 'sent', {})
    topics = fleet_topics.FleetTopics(('r',), 1.0, 0.5, print, StopGate())
    topics.do([AskPlanner(3, (Task('r', AGV, 1),), (), frozenset(), {}, seed=7)])
    (message,) = _Publisher.sent['/plan_request']
    assert (message.plan_id, message.seed) == (3, 7)
