"""Lines of the robot become events of the route follower."""
from __future__ import annotations

import pytest

from omron_ld90.bridge import route_protocol as p
from omron_ld90.bridge.bridge_words import RobotWords, is_motion, shown_events


@pytest.mark.parametrize('line, event', [
    ('Going to 12', p.GoalStarted('12')),
    ('Going to point', p.GoalStarted('')),
    ('Patrolling route round', p.GoalStarted('')),
    ('Arrived at 12', p.GoalReached('12')),
    ('Interrupted: Going to 12', p.MotionInterrupted('Going to 12')),
    ('Error: Failed going to goal', p.RobotFailed('Failed going to goal')),
    ('EStop pressed', p.EmergencyStop(True)),
    ('Estop relieved', p.EmergencyStop(True)),  # the motors are still off
    ('Motors enabled', p.EmergencyStop(False)),
    ('Motors disabled', p.RobotFailed('Motors disabled')),
    ('DockingState: Docked ForcedState: Unforced ChargeState: Bulk', p.Docking.DOCKED),
    ('Unknown command gotoGoals', p.CommandRejected('gotoGoals', 'Unknown command gotoGoals')),
])
def test_a_line_is_an_event(line, event):
    assert RobotWords().line(line, 0.0) == [event]


@pytest.mark.parametrize('line', ['', 'Stopped', 'Goal: 12', 'Temperature: 36', 'free text',
                                  'CommandErrorDescription: of nothing'])
def test_other_lines_are_none(line):
    assert RobotWords().line(line, 0.0) == []


def test_a_refused_command_waits_for_its_reason():
    words = RobotWords()
    assert words.line('CommandError: goto 99', 0.0) == []
    assert words.line('Map changed', 0.1) == []
    assert words.line("CommandErrorDescription: No goal '99'", 0.2) == [
        p.CommandRejected('goto 99', "No goal '99'")]
    assert words.overdue(9.0) == []


def test_a_reason_that_does_not_come_is_not_waited_for():
    words = RobotWords()
    words.line('CommandError: goto 99', 0.0)
    assert words.overdue(0.4) == []
    assert words.overdue(0.6) == [p.CommandRejected('goto 99', "the robot refused 'goto 99'")]


@pytest.mark.parametrize('text, events', [
    ('Going to 12', [p.GoalShown('12')]),
    ('Going to point', [p.GoalShown('')]),
    ('Arrived at 12', []),
    ('Stopped', []),
])
def test_the_status_text_shows_a_goal(text, events):
    assert shown_events(text) == events


@pytest.mark.parametrize('command, motion', [
    ('goto 12', True), ('stop', True), ('STOP', True), ('dock', True), ('undock', True),
    ('gotoPoint 1 2 3', True), ('status', False), ('getGoals', False), ('say hello', False),
    ('', False), ('go\nto', False), ('nonsense', False),
])
def test_what_counts_as_a_motion_command(command, motion):
    assert is_motion(command) is motion
