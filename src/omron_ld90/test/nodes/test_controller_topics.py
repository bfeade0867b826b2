"""A command that comes by a topic is carried out once for its sender; a refusal is reported."""
from __future__ import annotations

import math
from typing import Any, Callable, Dict, List, Optional, Tuple

import pytest
import rospy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from std_msgs.msg import String

from omron_arcl import Busy, Giver, Outcome, Result
from omron_ld90.nodes.controller_topics import TopicCommands
from omron_ld90.nodes.support.old_messages import WAITED

TOPICS = {'send_command': String, 'move_base_simple/goal': PoseStamped,
          'initialpose': PoseWithCovarianceStamped}
FLEET = 'The fleet drives the robot.'


class Bench:
    """Replaces ROS, OldMessages, Refusals and MoveBase, and keeps the commands that are given."""

    def __init__(self, monkeypatch: Any) -> None:
        self.heard: Dict[str, Callable[[Any], None]] = {}
        self.watched: List[str] = []
        self.old: Optional[str] = None  # why messages are too old; stops never are
        self.driven_by: Optional[str] = None  # why clicks may not move the robot
        self.busy = False
        self.given: List[Tuple[str, str]] = []
        self.forwarded: List[Tuple[PoseStamped, str]] = []
        self.refusals: List[Tuple[str, str, str]] = []
        self.on_end: Callable[[Result], None] = lambda _: None
        monkeypatch.setattr(rospy, 'Subscriber', self._subscribe)
        self.obeyed: Optional[str] = None  # the command that the robot obeys
        TopicCommands(self._execute, lambda text, _: text == self.obeyed, self, self, self, 'map',
                      lambda: self.driven_by)

    def _subscribe(self, topic: str, kind: type, callback: Callable, **_: Any) -> None:
        assert TOPICS[topic] is kind
        assert topic in self.watched, 'otherwise an earlier message could come first'
        self.heard[topic] = callback

    def watch(self, topic: str) -> None:
        self.watched.append(topic)

    def reason(self, message: Any, topic: str, is_stop: bool) -> Optional[str]:
        assert isinstance(message, TOPICS[topic])
        return None if is_stop else self.old

    def refused(self, text: str, caller: str, reason: str) -> None:
        self.refusals.append((text, caller, reason))

    def forward(self, pose: PoseStamped, giver: Giver) -> None:
        self.forwarded.append((pose, giver.name))

    def _execute(self, text: str, giver: Giver, on_end: Callable[[Result], None]) -> None:
        if self.busy:
            raise Busy(200, 'commands')
        self.given.append((text, giver.name))
        self.on_end = on_end

    def hear(self, topic: str, message: Any, caller: str = '/person') -> None:
        message._connection_header = {'callerid': caller}
        self.heard[topic](message)


@pytest.fixture
def bench(monkeypatch) -> Bench:
    return Bench(monkeypatch)


def goal(x: float = 1.0, y: float = 2.0, frame: str = 'map') -> PoseStamped:
    pose = PoseStamped()
    pose.header.frame_id = frame
    pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w = x, y, 1.0
    return pose


def estimate(**place: Any) -> PoseWithCovarianceStamped:
    stamped = goal(**place)
    pose = PoseWithCovarianceStamped(header=stamped.header)
    pose.pose.pose = stamped.pose
    return pose


def test_all_topics_are_heard(bench):
    assert set(bench.heard) == set(TOPICS)


def test_a_command_is_given_for_its_sender(bench):
    bench.hear('send_command', String('goto 12'), '/bridge')
    assert bench.given == [('goto 12', '/bridge')]
    assert bench.refusals == []


def test_a_goal_pose_becomes_a_goal_of_the_action(bench):
    pose = goal()
    bench.hear('move_base_simple/goal', pose, '/rviz')
    assert bench.forwarded == [(pose, '/rviz')]
    assert bench.given == []


def test_an_initial_pose_relocalises_in_whole_millimetres_and_degrees(bench):
    pose = estimate(x=1.2345, y=-2.0)
    pose.pose.pose.orientation.z = pose.pose.pose.orientation.w = math.sqrt(0.5)
    bench.hear('initialpose', pose, '/rviz')
    assert bench.given == [('localizeToPoint 1234 -2000 90', '/rviz')]


def test_a_pose_in_another_frame_or_that_is_none_is_told_and_not_given(bench):
    bench.hear('move_base_simple/goal', goal(frame='odom'))
    bench.hear('initialpose', estimate(x=math.nan))
    assert bench.given == bench.forwarded == []
    assert bench.refusals == [
        ('gotoPoint', '/person',
         'The goal was not sent: the pose is in the frame "odom", not in "map".'),
        ('localizeToPoint', '/person',
         'The pose was not sent: the pose contains a number that is not finite.')]


def test_while_a_fleet_drives_the_robot_clicks_do_not_and_commands_do(bench):
    bench.driven_by = FLEET
    bench.hear('move_base_simple/goal', goal())
    bench.hear('initialpose', estimate())
    assert bench.given == bench.forwarded == []
    assert bench.refusals == [('move_base_simple/goal', '/person', FLEET),
                             ('initialpose', '/person', FLEET)]
    bench.hear('send_command', String('goto 12'))
    assert bench.given == [('goto 12', '/person')]


def test_what_is_too_old_is_told_and_not_given_and_a_stop_never_is(bench):
    bench.old = WAITED
    bench.hear('send_command', String('goto 12'))
    bench.hear('move_base_simple/goal', goal())
    bench.hear('initialpose', estimate())
    assert bench.given == bench.forwarded == []
    assert [text for text, _, _ in bench.refusals] == ['goto 12', 'move_base_simple/goal',
                                                      'initialpose']
    assert {reason for _, _, reason in bench.refusals} == {WAITED}
    bench.hear('send_command', String('stop'))
    assert bench.given == [('stop', '/person')]


def test_a_command_that_cannot_be_given_is_told(bench):
    bench.busy = True
    bench.hear('send_command', String('goto 12'))
    assert bench.refusals == [('goto 12', '/person', str(Busy(200, 'commands')))]


@pytest.mark.parametrize(('outcome', 'is_told'), [
    (Outcome.FAILED, True), (Outcome.LOST, True), (Outcome.SUCCEEDED, False),
    (Outcome.INTERRUPTED, False)])
def test_a_command_that_comes_to_nothing_is_told(bench, outcome, is_told):
    bench.hear('send_command', String('goto 12'), '/bridge')
    bench.on_end(Result(outcome, 'no path', ()))
    told = [(text, caller) for text, caller, _ in bench.refusals]
    assert told == ([('goto 12', '/bridge')] if is_told else [])


def test_a_command_that_the_robot_obeys_already_is_not_given_again(bench):
    bench.hear('send_command', String('goto 12'))
    bench.obeyed = 'goto 12'
    bench.hear('send_command', String('goto 12'))
    bench.hear('send_command', String('goto 13'))
    assert [text for text, _ in bench.given] == ['goto 12', 'goto 13']
    assert not bench.refusals
