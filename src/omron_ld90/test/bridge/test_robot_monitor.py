"""Events of the robot that end a route, and the commands that are due."""
from __future__ import annotations

import pytest

from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import CommandFate
from omron_arcl.replies import DockingState
from omron_ld90.bridge.events import CommandEnded, LinkReported, MotionTold, RobotLink, RobotSeen
from omron_ld90.bridge.goal_tracker import RouteFailed
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_strategies import RouteSettings
from route_protocol.values import EpochCause, Reason, ReasonCode


def monitor() -> RobotMonitor:
    """Returns a monitor at time 0: both links are up, and the robot has been seen."""
    robot = RobotMonitor(RouteSettings(), RobotLink)
    for link in RobotLink:
        robot.update(LinkReported(link, True), 0.0)
    robot.update(RobotSeen(1, ActivityKind.STOPPED, place=(0.0, 0.0)), 0.0)
    return robot


def overrule(robot: RobotMonitor) -> None:
    robot.update(MotionTold(1), 0.0)
    robot.update(MotionTold(2, reason='"stop" of /rviz'), 0.0)


def why_failed(robot: RobotMonitor, now: float) -> str:
    with pytest.raises(RouteFailed) as failure:
        robot.check(now)
    return failure.value.reason.text


def test_a_command_is_due_once():
    robot = monitor()
    robot.tracker.send('12', 'goto 12')
    give, = robot.due_commands(0.0)
    assert give.command == 'goto 12'
    assert robot.due_commands(0.1) == []


def test_a_stop_takes_back_what_was_not_given_yet():
    robot = monitor()
    robot.tracker.send('12', 'goto 12')
    robot.stop(0)
    assert [give.command for give in robot.due_commands(0.0)] == ['stop']


def test_somebody_elses_stop_takes_over_and_does_not_end_the_stop_that_we_owe():
    robot = monitor()
    overrule(robot)
    robot.stop(0)
    assert [give.command for give in robot.due_commands(0.0)] == ['stop']
    assert why_failed(robot, 0.1) == 'taken over'


def test_a_command_carries_the_epoch_that_is_known():
    robot = monitor()
    overrule(robot)
    robot.tracker.send('12', 'goto 12')
    assert robot.due_commands(0.0) == [], 'the route has still to learn of it'
    robot.begin()
    robot.tracker.send('12', 'goto 12')
    assert [give.known_epoch for give in robot.due_commands(0.0)] == [2]


@pytest.mark.parametrize('told, fails', [
    (MotionTold(1, stop_owed=True), False), (MotionTold(2, 1, is_ours=True), False),
    (MotionTold(3, 1, is_ours=True), False), (MotionTold(3, 2, is_ours=True), True),
    (MotionTold(3, 1), False), (MotionTold(3, 2), True),
    (MotionTold(2, reason='"stop" of /rviz'), True)])
def test_only_what_others_do_ends_a_route_and_the_epoch(told, fails):
    robot = monitor()
    robot.update(MotionTold(1), 0.0)
    robot.update(told, 0.0)
    assert robot.epoch == told.epoch
    assert robot.overruled is (EpochCause.OTHER_GIVER if fails else None)
    if fails:
        assert why_failed(robot, 0.0) == 'taken over'
    else:
        robot.check(0.0)


def test_an_emergency_stop_ends_the_route_and_the_epoch_though_no_giver_took_over():
    robot = monitor()
    robot.update(MotionTold(1), 0.0)
    robot.update(MotionTold(2, is_ours=True, cause=EpochCause.EMERGENCY_STOP), 0.0)
    assert robot.overruled is EpochCause.EMERGENCY_STOP
    assert why_failed(robot, 0.0) == 'emergency stop'


def test_a_robot_is_not_driven_before_the_controller_has_told_who_drives_it():
    robot = monitor()
    assert 'the motion of the robot' in robot.why_unknown(0.0).text
    robot.update(MotionTold(1), 0.0)
    assert not robot.why_unknown(0.0)


def test_nor_before_it_has_told_why_the_robot_broke_off_a_drive():
    robot = monitor()
    robot.update(MotionTold(1), 0.0)
    robot.update(MotionTold(2, is_unexplained=True), 0.0)
    assert 'why it broke off its drive' in robot.why_unknown(0.0).text
    robot.check(0.0)
    assert robot.overruled is None
    robot.update(MotionTold(3, cause=EpochCause.OTHER_CLIENT), 0.0)
    assert not robot.why_unknown(0.0)
    assert robot.overruled is EpochCause.OTHER_CLIENT


@pytest.mark.parametrize('told, cause', [
    (MotionTold(3, 2, is_ours=True, cause=EpochCause.STOP), EpochCause.OTHER_GIVER),
    (MotionTold(3, 2), EpochCause.OTHER_GIVER),  # the controller was restarted meanwhile
    (MotionTold(3, cause=EpochCause.EMERGENCY_STOP), EpochCause.EMERGENCY_STOP)])
def test_an_epoch_of_ours_does_not_explain_why_the_robot_broke_off_a_drive(told, cause):
    robot = monitor()
    robot.update(MotionTold(1), 0.0)
    robot.update(MotionTold(2, is_unexplained=True), 0.0)
    robot.update(told, 0.0)
    assert robot.overruled is cause


def test_a_drive_that_somebody_else_lost_is_none_of_ours():
    robot = monitor()
    robot.update(MotionTold(1), 0.0)
    robot.update(MotionTold(2, is_unexplained=True), 0.0)
    assert not robot.tracker.awaits_motion


def test_a_location_is_overdue_only_while_its_link_stands():
    robot = monitor()
    for time in (1.0, 2.0, 3.0, 4.0, 5.0):
        for link in RobotLink:
            robot.update(LinkReported(link, True), time)
    robot.check(5.0)
    assert why_failed(robot, 5.5) == 'the robot has not reported its location for 5 s'
    robot = monitor()  # the receiver is suspended
    robot.update(LinkReported(RobotLink.COMMANDS, True), 5.0)
    robot.check(5.5)
    robot.update(LinkReported(RobotLink.OUTGOING, True), 9.5)
    robot.update(LinkReported(RobotLink.COMMANDS, True), 9.5)
    robot.check(10.0)


def test_of_a_link_that_is_down_that_is_told_not_that_nothing_comes_over_it():
    robot = monitor()
    robot.update(LinkReported(RobotLink.COMMANDS, True), 20.0)
    robot.update(LinkReported(RobotLink.OUTGOING, True), 20.0)
    assert robot.why_unknown(26.0).text.startswith(
        'lost link: commands: its node has reported nothing')
    robot.update(LinkReported(RobotLink.COMMANDS, True), 26.0)
    robot.update(LinkReported(RobotLink.OUTGOING, False, 'the robot hung up'), 26.0)
    assert robot.why_unknown(26.0).text == 'lost link: outgoing: the robot hung up'


def test_docked_is_known_as_soon_as_the_command_has_ended():
    robot = monitor()
    robot.tracker.send('dock', 'dock')
    give, = robot.due_commands(0.0)
    robot.update(CommandEnded(give.number, Outcome.SUCCEEDED), 9.0)
    assert robot.docking is DockingState.DOCKED
    assert robot.docking_changed == 9.0


def test_a_docking_state_that_is_not_told_is_the_last_one():
    robot = monitor()
    robot.update(RobotSeen(2, ActivityKind.DOCKED, docking=DockingState.DOCKED), 1.0)
    robot.update(RobotSeen(3, ActivityKind.DOCKED), 2.0)
    robot.update(RobotSeen(4, ActivityKind.DOCKED, docking=DockingState.DOCKED), 3.0)
    assert (robot.docking, robot.docking_changed) == (DockingState.DOCKED, 1.0)


def test_a_robot_that_somebody_drives_is_left_to_him():
    robot = monitor()
    robot.leave()
    assert robot.due_commands(60.0) == []


def test_a_new_route_begins_with_nothing_of_the_last_one():
    robot = monitor()
    robot.stop(0)
    overrule(robot)
    robot.tracker.failure = RouteFailed(Reason(ReasonCode.DRIVE_FAILED, 'Failed going to goal'))
    robot.begin()
    robot.check(0.1)
    assert robot.due_commands(0.1) == []


def test_of_several_reasons_the_emergency_stop_is_told_and_then_a_take_over():
    robot = monitor()
    robot.tracker.failure = RouteFailed(Reason(ReasonCode.DRIVE_FAILED, 'Failed going to goal'))
    assert why_failed(robot, 0.1) == 'Failed going to goal'
    overrule(robot)
    assert why_failed(robot, 0.1) == 'taken over'
    robot.update(MotionTold(2, 1, emergency_stop=True), 0.1)
    assert why_failed(robot, 0.1) == 'emergency stop'


def test_a_lost_command_is_given_again_only_when_the_link_stands():
    robot = monitor()
    robot.tracker.send('12', 'goto 12')
    give, = robot.due_commands(0.0)
    robot.update(LinkReported(RobotLink.COMMANDS, False), 1.0)
    robot.update(CommandEnded(give.number, Outcome.LOST), 1.0)
    robot.update(MotionTold(7, number=give.number, fate=CommandFate.UNKNOWN), 2.0)
    robot.update(LinkReported(RobotLink.COMMANDS, True), 3.0)
    assert robot.due_commands(3.5) == [], 'the robot may obey it'
    robot.update(LinkReported(RobotLink.COMMANDS, False), 4.0)
    robot.update(MotionTold(7, number=give.number, fate=CommandFate.NOT_OBEYED), 4.0)
    assert robot.due_commands(4.5) == []
    robot.update(LinkReported(RobotLink.COMMANDS, True), 5.0)
    again, = robot.due_commands(5.5)
    assert (again.command, again.number) == ('goto 12', give.number + 1)


def test_numbers_of_commands_grow_also_above_one_that_only_the_controller_knows():
    robot = monitor()
    robot.update(MotionTold(7, number=50, fate=CommandFate.OBEYED), 0.0)
    robot.tracker.send('12', 'goto 12')
    assert robot.due_commands(0.0)[0].number > 50


def own(epoch: int) -> MotionTold:
    """Returns the event that the robot obeys a drive of ours."""
    return MotionTold(epoch, 5, is_ours=True, obeys_us=True)


def others(epoch: int, cause: EpochCause, number: int) -> MotionTold:
    """Returns an event: others have acted, and the robot does not obey our last drive."""
    return MotionTold(epoch, reason='why', cause=cause,
                      is_ours=cause is EpochCause.EMERGENCY_STOP, number=number,
                      fate=CommandFate.NOT_OBEYED)


@pytest.mark.parametrize('cause, why', [
    (EpochCause.OTHER_GIVER, 'taken over'),   # another program drives or stops the robot
    (EpochCause.CANCEL, 'taken over'),        # a person cancels the drive
    (EpochCause.OTHER_CLIENT, 'taken over'),  # another client of the robot drives or stops it
    (EpochCause.ROBOT, 'taken over'),         # the robot docks by itself
    (EpochCause.EMERGENCY_STOP, 'emergency stop')])
@pytest.mark.parametrize('ending, obeyed_before', [
    *((ending, obeyed) for ending in (Outcome.INTERRUPTED, Outcome.CANCELLED, Outcome.LOST, None)
      for obeyed in (True, False)), (Outcome.OVERRULED, False)])
@pytest.mark.parametrize('told_first', [True, False])
def test_the_epoch_tells_why_a_drive_ended_before_and_after_its_result(
        cause, why, ending, obeyed_before, told_first):
    """The drive is not given again, however late the epoch or the result comes."""
    robot = monitor()
    robot.update(MotionTold(5), 0.0)
    robot.tracker.send('12', 'goto 12')
    give, = robot.due_commands(0.0)
    events = [own(6)] * obeyed_before + [others(7 if obeyed_before else 6, cause, give.number)]
    result = [CommandEnded(give.number, ending, 'words')] if ending else []
    *before, last = [*events, *result] if told_first else [*result, *events]
    for event in before:
        robot.update(event, 1.0)
        assert robot.due_commands(1.0) == []
    if not told_first or not result:
        robot.check(1.0)
    robot.update(last, 1.0)
    assert why_failed(robot, 1.0) == why


@pytest.mark.parametrize('cause, again', [(EpochCause.RESTART, True), (EpochCause.STOP, False)])
def test_a_drive_for_an_epoch_that_ended_with_the_controller_is_given_again(cause, again):
    """The controller publishes NOT_OBEYED for such a drive."""
    robot = monitor()
    robot.update(MotionTold(5), 0.0)
    robot.tracker.send('12', 'goto 12')
    give, = robot.due_commands(0.0)
    foreign = 5 if cause is EpochCause.RESTART else 6
    robot.update(MotionTold(6, foreign, cause=cause), 1.0)
    robot.update(CommandEnded(give.number, Outcome.OVERRULED, 'the controller was started'), 1.1)
    assert robot.due_commands(1.1) == []
    robot.update(MotionTold(6, foreign, cause=cause, number=give.number,
                            fate=CommandFate.NOT_OBEYED), 1.2)
    commands = [(one.command, one.known_epoch) for one in robot.due_commands(1.2)]
    assert commands == ([('goto 12', 6)] if again else [])
    if again:
        robot.check(3.0)
    else:
        assert why_failed(robot, 3.0) == 'taken over'
