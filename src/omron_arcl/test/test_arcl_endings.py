"""Refusals and failures end the command that they belong to, in any spelling."""
from __future__ import annotations

import pytest
from arcl_builders import Conversation, outcome

from omron_arcl import Outcome


@pytest.fixture
def talk() -> Conversation:
    return Conversation()


@pytest.mark.parametrize('said', [
    ('CommandError: goto 99', "CommandErrorDescription: No goal '99'"),
    ('CommandError: GOTO  "99"', "CommandErrorDescription: No goal '99'"),
    ('CommandError: goto', 'CommandErrorDescription: Goal 99 not found'),
    ("CommandErrorDescription: No goal '99'",), ("No goal '99'",), ('No such goal "99"',),
    ('CommandError: goto 99', 'CommandErrorDescription: Unknown goal 99'),
])
def test_a_goal_that_the_robot_lacks_is_refused_in_various_words(talk, said):
    running, goto = talk.give('goto 12'), talk.give('goto 99')
    talk.robot('Going to 12', *said)
    assert outcome(goto) is Outcome.NO_GOAL
    assert running.result is None


def test_a_description_that_comes_much_too_late_refuses_nothing_else(talk):
    refused = talk.give('goto 99')
    talk.robot('CommandError: goto 99')
    talk.pass_time(1.5)
    assert outcome(refused) is Outcome.REJECTED
    goto = talk.give('goto 12')
    talk.robot("CommandErrorDescription: No goal '99'")
    assert goto.result is None


@pytest.mark.parametrize('said', [
    'Unknown command goto', 'Unknown command: goto', "Unknown command 'goto'", 'unknown command',
    'Unknown command "goto".'])
def test_an_unknown_command_is_told_in_various_words(talk, said):
    goto = talk.give('goto 12')
    talk.robot(said)
    assert outcome(goto) is Outcome.UNKNOWN_COMMAND


@pytest.mark.parametrize('said', [
    'EStop pressed', 'Estop pressed', 'E-Stop pressed', 'Emergency stop pressed',
    'EStop button pressed', 'Error: Emergency stop pressed', 'Error: EStop pressed'])
def test_an_emergency_stop_is_told_in_various_words(talk, said):
    drive, other = talk.give('goto 12'), talk.give('dock')
    talk.robot('Going to 12', said)
    assert outcome(drive) is Outcome.EMERGENCY_STOPPED
    assert outcome(other) is Outcome.EMERGENCY_STOPPED


@pytest.mark.parametrize('said', ['EStop pressed', 'EStop relieved but motors still disabled'])
def test_a_drive_refused_for_the_emergency_stop_has_the_same_outcome(talk, said):
    drive, other = talk.give('goto 12'), talk.give('getGoals')
    talk.robot('CommandError: goto 12', f'CommandErrorDescription: {said}')
    assert outcome(drive) is Outcome.EMERGENCY_STOPPED
    assert other.result is None


@pytest.mark.parametrize('said', ['Motors disabled', 'Motors are disabled'])
def test_disabled_motors_fail_a_drive(talk, said):
    drive = talk.give('goto 12')
    talk.robot('Going to 12', said)
    assert outcome(drive) is Outcome.FAILED


@pytest.mark.parametrize('said', [
    'Failed going to goal', 'Failed going to 12', 'Failed going to -597 -5765',
    'Error: Cannot find path', 'Cannot find path', 'Failed to drive to Target',
    'Unable to plan a path', 'Could not reach goal'])
def test_a_drive_that_cannot_begin_is_told_in_various_words(talk, said):
    drive = talk.give('goto 12')
    talk.robot(said)
    assert outcome(drive) is Outcome.FAILED


@pytest.mark.parametrize('said', ['Cannot find path', 'Failed to drive to Target', 'Stalled'])
def test_free_words_of_failure_end_a_drive_that_does_not_go_on(talk, said):
    drive = talk.give('goto 12')
    talk.robot('Going to 12', said)
    assert drive.result is None
    talk.pass_time(10.0)
    assert outcome(drive) is Outcome.FAILED
    assert drive.result.words == said


@pytest.mark.parametrize('said', ['Cannot open sound file', 'Failed to play'])
def test_a_failure_of_something_else_is_none_of_a_drive_that_has_not_begun(talk, said):
    drive = talk.give('goto 12')
    talk.robot(said)
    assert drive.result is None


@pytest.mark.parametrize('said', ['Failed to localize at point', 'Cannot localise'])
def test_relocalising_fails_in_various_words(talk, said):
    localize = talk.give('localizeToPoint 1 2 3')
    talk.robot('Localizing at point', said)
    assert outcome(localize) is Outcome.FAILED
