"""/fleet_plan needs no CPU time without subscribers. A new subscriber gets the newest plan."""
from __future__ import annotations

import queue
from typing import Any, List

import pytest
import rospy

from graph_fleet_manager.nodes import fleet_plan
from graph_fleet_manager.nodes.fleet_plan import FleetPlanTopic


class _Publisher:
    """A publisher; the test sets the number of its subscribers."""

    subscribers = 0

    def __init__(self, *_: Any, subscriber_listener: Any, **__: Any) -> None:
        self.connects = lambda: subscriber_listener.peer_subscribe('/fleet_plan', None, None)
        self.stamps: queue.Queue[int] = queue.Queue()

    def get_num_connections(self) -> int:
        return self.subscribers

    def publish(self, message: Any) -> None:
        self.stamps.put(message.header.stamp.secs)


@pytest.fixture
def made(monkeypatch) -> List[float]:
    """Returns a list with one entry for each plan for which views were made."""
    found: List[float] = []

    def plan_views(progress):
        found.append(progress)
        return []

    monkeypatch.setattr(fleet_plan, 'plan_views', plan_views)
    monkeypatch.setattr(rospy, 'Publisher', _Publisher)
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: False)
    return found


def tell(topic: FleetPlanTopic, second: int) -> None:
    topic.set_plan(None, float(second), rospy.Time(second))


def test_without_a_subscriber_no_plan_is_made_and_the_first_one_gets_the_newest(made):
    topic = FleetPlanTopic(1.0)
    publisher = topic._publisher
    publisher.connects()  # there is no plan yet
    for second in range(1, 50):
        tell(topic, second)
    assert not made
    publisher.connects()
    assert publisher.stamps.get(timeout=10.0) == 49 and len(made) == 1


def test_a_subscriber_gets_each_new_plan(made):
    topic = FleetPlanTopic(1.0)
    publisher = topic._publisher
    tell(topic, 1)
    publisher.subscribers = 1
    publisher.connects()
    tell(topic, 2)
    while publisher.stamps.get(timeout=10.0) != 2:
        pass
