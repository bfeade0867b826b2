"""Messages of the robot's nodes become events of the bridge."""
from __future__ import annotations

import math

import genpy
import pytest

from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import CommandFate, MotionState
from omron_arcl.replies import DockingState
from omron_ld90.bridge.events import CommandEnded, LinkReported, MotionTold, RobotLink, RobotSeen
from omron_ld90.nodes.bridge_messages import (
    command_ended,
    link_reported,
    motion_told,
    robot_seen,
)
from omron_ld90_msgs.msg import (
    ExecuteCommandResult,
    LastCommand,
    LinkState,
    Motion,
    RobotStatus,
)
from route_protocol.values import EpochCause


def test_a_status_tells_where_the_robot_is_and_what_it_does():
    status = RobotStatus(activity=RobotStatus.GOING_TO_GOAL, goal='12', has_pose=True,
                         docking_state='Undocked')
    status.header.stamp = genpy.Time(12, 5)
    status.pose.position.x, status.pose.position.y = 1.5, -2.0
    status.pose.orientation.z = status.pose.orientation.w = math.sqrt(0.5)
    assert robot_seen(status) == RobotSeen(
        12_000_000_005, ActivityKind.GOING_TO_GOAL, DockingState.UNDOCKED, (1.5, -2.0),
        pytest.approx(math.pi / 2.0))


def test_a_status_without_a_pose_has_no_place():
    assert robot_seen(RobotStatus()) == RobotSeen(0)


@pytest.mark.parametrize('kind', ActivityKind)
def test_an_activity_is_told_as_it_is(kind):
    status = RobotStatus(activity=getattr(RobotStatus, kind.name))
    assert robot_seen(status).activity is kind


@pytest.mark.parametrize('outcome, message, ending', [
    ('SUCCEEDED', 'Arrived at 12', Outcome.SUCCEEDED),
    ('FAILED', 'Failed going to goal', Outcome.FAILED),
    ('INTERRUPTED', 'replaced', Outcome.INTERRUPTED),
    ('CANCELLED', 'cancelled', Outcome.CANCELLED),
    ('TIMED_OUT', 'silent', Outcome.FAILED),
    ('REFUSED', 'not allowed', Outcome.FAILED),
    ('EMERGENCY_STOPPED', 'EStop pressed', Outcome.EMERGENCY_STOPPED),
    ('LOST', 'the connection broke', Outcome.LOST),
    ('LOST', 'never sent: so it says', Outcome.LOST),
    ('NEVER_SENT', 'no link', Outcome.NEVER_SENT),
    ('OVERRULED', 'Not sent, "stop" of /rviz came first.', Outcome.OVERRULED),
])
def test_an_outcome_is_an_ending(outcome, message, ending):
    result = ExecuteCommandResult(outcome=getattr(ExecuteCommandResult, outcome), message=message)
    assert command_ended(3, result) == CommandEnded(3, ending, message)


@pytest.mark.parametrize('giver, cause, is_ours', [
    ('/r/bridge', EpochCause.OTHER_GIVER, True), ('/rviz', EpochCause.STOP, False),
    ('', EpochCause.OTHER_CLIENT, False), ('', EpochCause.EMERGENCY_STOP, True),
    ('', EpochCause.RESTART, False)])
def test_a_motion_is_that_of_the_bridge_or_of_somebody_else(giver, cause, is_ours):
    told = Motion(epoch=9, previous_epoch=7, foreign_epoch=8, giver=giver, cause=int(cause),
                  stop_owed=True, reason='why')
    assert motion_told(told, '/r/bridge') == MotionTold(
        9, 8, is_ours, True, 'why',
        EpochCause.OTHER_GIVER if cause is EpochCause.STOP else cause,
        obeys_us=giver == '/r/bridge', fate=CommandFate.NOT_OBEYED, giver=giver,
        previous_epoch=7)


@pytest.mark.parametrize('fate', CommandFate)
def test_a_motion_tells_what_became_of_the_last_command_of_the_bridge(fate):
    told = motion_told(Motion(last_commands=[
        LastCommand('/rviz', 3, LastCommand.FAILED, 8),
        LastCommand('/r/bridge', 2 ** 40, getattr(LastCommand, fate.name), 7)]), '/r/bridge')
    assert (told.number, told.fate, told.foreign_epoch) == (2 ** 40, fate, 7)


@pytest.mark.parametrize('state', MotionState)
def test_a_motion_tells_what_the_robot_does(state):
    assert motion_told(Motion(state=getattr(Motion, state.name)), '/r').state is state


def test_a_state_that_this_program_does_not_know_is_unknown():
    assert motion_told(Motion(state=200), '/r').state is MotionState.UNKNOWN


@pytest.mark.parametrize('pressed', [False, True])
def test_a_motion_tells_whether_the_robot_is_in_its_emergency_stop(pressed):
    assert motion_told(Motion(emergency_stop=pressed), '/r').emergency_stop is pressed


def test_each_cause_of_the_controller_is_one_of_the_protocol():
    names = [cause.name for cause in EpochCause if hasattr(Motion, cause.name)]
    assert names == ['OTHER_GIVER', 'STOP', 'CANCEL', 'OTHER_CLIENT', 'ROBOT', 'EMERGENCY_STOP',
                     'RESTART']
    for name in names:
        told = motion_told(Motion(cause=getattr(Motion, name)), '').cause.name
        assert told == ('OTHER_GIVER' if name == 'STOP' else name)


def test_a_link_is_up_or_down_for_a_reason_and_only_the_robots_two_count():
    assert link_reported(LinkState(link='commands', state=LinkState.CONNECTED)) == LinkReported(
        RobotLink.COMMANDS, True)
    assert link_reported(LinkState(link='outgoing', state=LinkState.CONNECTING)) == LinkReported(
        RobotLink.OUTGOING, False, 'connecting')
    assert link_reported(LinkState(link='forged', state=LinkState.DISCONNECTED)) is None
