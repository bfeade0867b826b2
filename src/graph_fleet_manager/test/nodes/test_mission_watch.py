"""`mission --wait` notices the end of its mission, even if messages were lost."""
from __future__ import annotations

from typing import FrozenSet, List, Optional

import pytest
import rospy

from fleet_core.supervision.missions import MissionState, Status
from fleet_requests import SILENCE
from graph_fleet_manager.commands.mission_watch import MissionWatch
from graph_fleet_manager.messages.missions import status_message
from itrci_nav_msgs.msg import MissionRequest, MissionStatus

STAMP = 1.7e9


def status(state: MissionState, stamp: float = STAMP) -> MissionStatus:
    return status_message(Status(7, state, 'a', 1, '', stamp), rospy.Time(5))


class Fleet:
    """A fleet manager whose messages can be lost, and whose stored states can be read."""

    def __init__(self) -> None:
        self.topic: List[MissionStatus] = []
        self.stored: Optional[MissionStatus] = None
        self.connections: FrozenSet[int] = frozenset((1,))
        self.asked, self.now = 0, 0.0
        request = MissionRequest(request_id=7)
        request.header.stamp = rospy.Time.from_sec(STAMP)
        self.watch = MissionWatch(request, status(MissionState.PENDING), self, self.ask,
                                  lambda: self.now)

    def unread(self) -> List[MissionStatus]:
        told, self.topic = self.topic, []
        return told

    def wait(self, seconds: float) -> None:
        self.now += seconds

    def publishers(self) -> FrozenSet[int]:
        return self.connections

    def ask(self) -> Optional[MissionStatus]:
        self.asked += 1
        return self.stored

    def state(self) -> MissionState:
        return MissionState(self.watch.wait(0.5).state)


@pytest.fixture
def fleet() -> Fleet:
    return Fleet()


def test_an_end_that_was_told_before_the_program_listened_is_found(fleet):
    fleet.stored = status(MissionState.SUCCEEDED)
    assert fleet.state() is MissionState.SUCCEEDED


def test_an_end_that_died_with_the_fleet_manager_is_found_at_its_restart(fleet):
    fleet.stored = status(MissionState.ACTIVE)
    assert fleet.state() is MissionState.ACTIVE
    fleet.connections = frozenset()  # the fleet manager is killed between commit and message
    assert fleet.state() is MissionState.ACTIVE
    fleet.connections, fleet.stored = frozenset((2,)), status(MissionState.SUCCEEDED)
    assert fleet.state() is MissionState.SUCCEEDED


def test_a_fleet_manager_that_does_not_answer_yet_is_asked_again(fleet):
    assert fleet.state() is MissionState.PENDING
    fleet.stored = status(MissionState.CANCELLED)
    assert fleet.state() is MissionState.CANCELLED


def test_an_end_that_a_full_queue_has_dropped_is_found_after_some_silence(fleet):
    fleet.stored = status(MissionState.ACTIVE)
    fleet.state()
    fleet.stored = status(MissionState.FAILED)
    while fleet.now < SILENCE:
        assert fleet.state() is MissionState.ACTIVE
    fleet.now += 1.0
    assert fleet.state() is MissionState.FAILED


def test_nothing_is_asked_while_news_come(fleet):
    fleet.stored = status(MissionState.ACTIVE)
    fleet.state()
    for _ in range(100):
        fleet.topic.append(status(MissionState.ACTIVE))
        fleet.state()
    assert fleet.asked == 1


def test_news_of_another_mission_with_the_same_id_are_no_news(fleet):
    fleet.stored = status(MissionState.ACTIVE)
    fleet.topic = [status(MissionState.FAILED, STAMP - 60.0)]
    assert fleet.state() is MissionState.ACTIVE
