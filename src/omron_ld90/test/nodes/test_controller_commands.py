"""The controller's commands: their possible ends, repetitions, and refusals."""
from __future__ import annotations

import math
from typing import Optional

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import PoseStamped

from omron_arcl import Execution, Giver, HelpList, Outcome, Result, parse_command
from omron_ld90.nodes import controller_help
from omron_ld90.nodes.controller_actions import GoalRefused
from omron_ld90.nodes.controller_execute_command import _OUTCOMES
from omron_ld90.nodes.controller_help import HelpReport
from omron_ld90.nodes.controller_move_base import robot_pose
from omron_ld90.nodes.controller_refusals import failure
from omron_ld90.nodes.controller_repeats import ObeyedDrive
from omron_ld90_msgs.msg import ExecuteCommandResult

# -- each way in which a command can end has its own outcome ---------------------------------------

def test_every_way_to_end_has_an_outcome_of_the_action():
    assert set(_OUTCOMES) == set(Outcome)
    assert _OUTCOMES[Outcome.EMERGENCY_STOPPED] == ExecuteCommandResult.EMERGENCY_STOPPED
    assert _OUTCOMES[Outcome.LOST] == ExecuteCommandResult.LOST


# -- a failed command gives one clear message ------------------------------------------------------

@pytest.mark.parametrize(('outcome', 'words'), [
    (Outcome.NO_GOAL, 'refused by the robot'), (Outcome.UNKNOWN_COMMAND, 'refused by the robot'),
    (Outcome.REJECTED, 'refused by the robot'), (Outcome.FAILED, 'failed'),
    (Outcome.EMERGENCY_STOPPED, 'emergency stop'), (Outcome.TIMED_OUT, 'timed out'),
    (Outcome.LOST, 'lost')])
def test_a_command_that_came_to_nothing_is_told_with_the_robots_words(outcome, words):
    sentence = failure('goto 12', Result(outcome, 'No \x1b[2J goal', ()))
    assert sentence.startswith("Command 'goto 12' ")
    assert words in sentence
    assert sentence.endswith(r': No \x1b[2J goal.')


@pytest.mark.parametrize('outcome', [Outcome.SUCCEEDED, Outcome.INTERRUPTED, Outcome.CANCELLED])
def test_a_command_that_was_done_or_replaced_did_not_come_to_nothing(outcome):
    assert failure('goto 12', Result(outcome, '', ())) is None


# -- which command would only repeat the drive that the robot obeys --------------------------------

PERSON, FLEET = Giver('/person', 'a'), Giver('/fleet', 'b')


def after(*texts: str, giver: Giver = PERSON) -> ObeyedDrive:
    drive = ObeyedDrive()
    for text in texts:
        drive.given(Execution(parse_command(text), giver=giver))
    return drive


def repeats(drive: ObeyedDrive, text: str, giver: Giver = PERSON, epoch: int = 0) -> bool:
    return drive.same_as(text, giver, epoch) is not None


@pytest.mark.parametrize('text', ['goto 12', 'goto 12 90', 'gotoPoint 1000 -200 90',
                                  'gotoRouteGoal tour 12', 'dock', ' goto 12 '])
def test_a_drive_to_a_place_is_repeated_by_the_same_words_of_the_same_giver(text):
    assert repeats(after(text), text)
    assert repeats(after(text, 'getGoals', 'say hello'), text)


@pytest.mark.parametrize('text', ['move 1000', 'patrolOnce tour', 'queueDropoff 12', 'say hello',
                                  'undock', 'stop', 'localizeToPoint 1 2 3'])
def test_a_command_that_is_meant_again_each_time_is_never_a_repetition(text):
    assert not repeats(after(text), text)


@pytest.mark.parametrize('text, giver, epoch', [
    ('goto 13', PERSON, 0), ('goto 12 90', PERSON, 0), ('goto 12', FLEET, 0),
    ('goto 12', Giver('/person', 'restarted'), 0), ('goto 12', PERSON, 7)])
def test_another_command_giver_or_epoch_is_no_repetition(text, giver, epoch):
    assert not repeats(after('goto 12'), text, giver, epoch)


@pytest.mark.parametrize('between', ['stop', 'goto 13', 'undock', 'move 100'])
def test_after_other_motion_the_same_drive_is_given_anew(between):
    assert not repeats(after('goto 12', between), 'goto 12')


@pytest.mark.parametrize('outcome', [None, *Outcome])
def test_after_its_end_and_its_cancellation_a_drive_is_given_anew(outcome: Optional[Outcome]):
    drive, execution = ObeyedDrive(), Execution(parse_command('goto 12'), giver=PERSON)
    drive.given(execution)
    assert repeats(drive, 'goto 12')
    if outcome is None:
        execution.progress.cancel_requested = 1.0
    else:
        execution.end(outcome, '')
    assert not repeats(drive, 'goto 12')


# -- commands that the help list lacks are named in a warning, and sent ----------------------------

@pytest.fixture(autouse=True)
def warnings(monkeypatch) -> list:
    said = []
    monkeypatch.setattr(controller_help.rospy, 'logwarn', lambda *words: said.append(words))
    return said


def report(*listed: str, sent: tuple = ()) -> DiagnosticStatusWrapper:
    help_report = HelpReport()
    help_report.listed(HelpList(dict.fromkeys(listed, '')))
    for text in sent:
        help_report.sent(parse_command(text))
    return help_report.diagnose(DiagnosticStatusWrapper())


def test_what_the_robot_lists_is_well():
    assert report('goto', 'stop', sent=('goto 1', 'STOP')).level == DiagnosticStatus.OK


def test_what_it_does_not_list_is_a_warning_said_once(warnings):
    status = report('stop', sent=('goto 1', 'goto 2', 'patrol r'))
    assert status.level == DiagnosticStatus.WARN
    assert status.message.endswith('goto, patrol')
    assert len(warnings) == 2


def test_a_robot_without_a_help_list_is_no_warning():
    assert report(sent=('goto 1',)).level == DiagnosticStatus.OK


# -- poses become whole millimetres and degrees ----------------------------------------------------

def pose(x: float = 1.0, y: float = 2.0, yaw: float = 0.0, frame: str = 'map') -> PoseStamped:
    stamped = PoseStamped()
    stamped.header.frame_id = frame
    stamped.pose.position.x, stamped.pose.position.y = x, y
    stamped.pose.orientation.z, stamped.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return stamped


def test_a_pose_becomes_whole_millimetres_and_degrees():
    assert robot_pose(pose(1.2345, -2.0, math.radians(-90)), 'map') == (1234, -2000, -90)


@pytest.mark.parametrize(('bad', 'reason'), [
    (pose(frame='odom'), '"odom"'), (pose(frame=''), '""'), (pose(x=math.nan), 'finite'),
    (pose(y=math.inf), 'finite'), (pose(x=1e9), 'away'), (PoseStamped(), 'frame'),
])
def test_a_pose_that_is_none_is_refused(bad, reason):
    with pytest.raises(GoalRefused, match=reason):
        robot_pose(bad, 'map')


def test_an_orientation_that_is_none_is_refused():
    bad = pose()
    bad.pose.orientation.w = 0.0
    with pytest.raises(GoalRefused, match='unit quaternion'):
        robot_pose(bad, 'map')
