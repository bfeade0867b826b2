"""What ends a route on the robot's side, and which commands are due."""
from __future__ import annotations

import pytest

from omron_ld90.bridge.events import (
    CommandEnded,
    Docking,
    Ending,
    ForeignStop,
    Link,
    LinkReported,
    Motion,
    RobotSeen,
)
from omron_ld90.bridge.goal_tracker import RouteFailed
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_strategies import Settings


def monitor() -> RobotMonitor:
    """Both links stand and the robot has been seen, at time 0."""
    robot = RobotMonitor(Settings(), Link)
    for link in Link:
        robot.update(LinkReported(link, True), 0.0)
    robot.update(RobotSeen(1, Motion.STANDING, place=(0.0, 0.0)), 0.0)
    return robot


def why_failed(robot: RobotMonitor, now: float) -> str:
    with pytest.raises(RouteFailed) as failure:
        robot.check(now)
    return failure.value.reason


def test_a_command_is_due_once():
    robot = monitor()
    robot.tracker.send('12', 'goto 12')
    give, = robot.due_commands(0.0)
    assert give.command == 'goto 12'
    assert robot.due_commands(0.1) == []


def test_a_stop_goes_before_everything_else():
    robot = monitor()
    robot.tracker.send('12', 'goto 12')
    robot.stop_duty.require(0.0)
    assert [give.command for give in robot.due_commands(0.0)] == ['stop', 'goto 12']


def test_a_stop_takes_back_what_was_not_given_yet():
    robot = monitor()
    robot.tracker.send('12', 'goto 12')
    robot.stop(0.0)
    assert [give.command for give in robot.due_commands(0.0)] == ['stop']


def test_somebody_elses_stop_takes_over_and_does_not_end_the_stop_that_we_owe():
    robot = monitor()
    robot.stop(0.0)
    robot.update(ForeignStop('/rviz'), 0.0)
    assert [give.command for give in robot.due_commands(0.0)] == ['stop']
    assert why_failed(robot, 0.1) == 'taken over'


def test_a_location_is_overdue_only_while_its_link_stands():
    robot = monitor()
    for time in (1.0, 2.0, 3.0, 4.0, 5.0):
        for link in Link:
            robot.update(LinkReported(link, True), time)
    assert why_failed(robot, 5.5) == 'the robot has not told where it is for 5 s'
    robot = monitor()  # the receiver stands still
    robot.update(LinkReported(Link.COMMANDS, True), 5.0)
    robot.check(5.5)
    robot.update(LinkReported(Link.OUTGOING, True), 9.5)
    robot.update(LinkReported(Link.COMMANDS, True), 9.5)
    robot.check(10.0)


def test_docked_is_known_as_soon_as_the_command_has_ended():
    robot = monitor()
    robot.tracker.send('dock', 'dock')
    give, = robot.due_commands(0.0)
    robot.update(CommandEnded(give.number, Ending.SUCCEEDED), 9.0)
    assert robot.docking is Docking.DOCKED
    assert robot.docking_changed == 9.0
