"""The planner answers each request once, even if the request comes twice."""
from __future__ import annotations

import threading
from typing import List

import genpy
import pytest

from graph_fleet_manager.messages.edge_times import TimesKept
from graph_fleet_manager.nodes.path_planner import PathPlanner
from itrci_nav_msgs.msg import PlanAnswer, PlanRequest


class Answers:
    """The publisher of answers."""

    def __init__(self) -> None:
        self.sent: List[PlanAnswer] = []

    def publish(self, answer: PlanAnswer) -> None:
        self.sent.append(answer)


@pytest.fixture
def planner():
    """Returns a planner that has no thread, so each request waits."""
    planner = object.__new__(PathPlanner)
    planner._changed, planner._times, planner._rate = threading.Condition(), TimesKept(), 1.0
    planner._request, planner._answers = None, Answers()
    return planner


def request(plan_id: int, seconds: int) -> PlanRequest:
    message = PlanRequest(plan_id=plan_id)
    message.header.stamp = genpy.Time(seconds)
    return message


def test_a_request_that_comes_twice_does_not_supersede_itself(planner):
    planner._on_request(request(1, 5))
    planner._on_request(request(1, 5))
    assert planner._answers.sent == []


@pytest.mark.parametrize('newer', [request(2, 6), request(1, 6)])  # 2nd: of another supervisor
def test_a_newer_request_supersedes_the_one_that_waits(planner, newer):
    planner._on_request(request(1, 5))
    planner._on_request(newer)
    assert [(answer.plan_id, answer.result) for answer in planner._answers.sent] == [
        (1, PlanAnswer.SUPERSEDED)]
