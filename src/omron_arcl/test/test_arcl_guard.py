"""The controller lets some commands through, and refuses the others with a reason."""
from __future__ import annotations

import pytest
from drive_bench import ROUTE, Bench

from omron_arcl import HelpList, InvalidCommand, parse_command
from omron_arcl.guard import Guard, is_unlisted
from omron_arcl.records import DriveMemory, MotionState, RobotMotion


@pytest.fixture
def guard() -> Guard:
    return Guard(['motion', 'query'])


def reason(guard: Guard, text: str, **shortcuts: str) -> str:
    with pytest.raises(InvalidCommand) as refused:
        guard.check(parse_command(text, shortcuts.get))
    return str(refused.value)


def passes(guard: Guard, text: str) -> None:
    guard.check(parse_command(text))


@pytest.mark.parametrize('text', ['goto 12', 'stop', 'getGoals', 'localizeToPoint 1 2 3', 'STATUS'])
def test_motion_and_queries_pass(guard, text):
    passes(guard, text)


@pytest.mark.parametrize('text', ['shutdown', 'ShutDown', 'configStart', 'quit', 'say hello',
                                  'connectOutgoing 10.0.0.1 7179', 'abracadabra', '"shutdown"'])
def test_everything_else_is_refused_with_the_way_to_allow_it(guard, text):
    assert '~allowed_commands' in reason(guard, text)


def test_a_command_can_be_allowed_by_name(guard):
    guard = Guard(['query', 'Say', 'newFangled'])
    passes(guard, 'say hello')
    passes(guard, 'newFangled')
    reason(guard, 'play a.wav')
    reason(guard, 'goto 12')
    assert guard.unknown_words() == {'newfangled'}


@pytest.mark.parametrize('allowed', [[], ['query', 'goto'], ['device']])
def test_stop_cannot_be_forbidden(allowed):
    passes(Guard(allowed), 'stop')
    passes(Guard(allowed), 'STOP')


def test_a_shortcut_is_no_way_around_the_guard(guard):
    assert 'dangerous' in reason(guard, 'sd', sd='shutdown')


def test_a_command_that_the_robot_does_not_list_is_no_secret_but_passes(guard):
    help_list = HelpList({'goto': 'Goes to a goal', 'applicationFaultQuery': 'Faults [afq]'})
    passes(guard, 'patrol r')
    assert is_unlisted(parse_command('patrol r'), help_list)
    for listed in ('GOTO 12', 'afq', 'applicationfaultquery'):
        assert not is_unlisted(parse_command(listed), help_list)


def test_a_robot_without_a_help_list_is_not_compared_with_it():
    assert not is_unlisted(parse_command('patrol r'), HelpList({}))


@pytest.mark.parametrize('text', ['goto 12', 'goto X', 'goto "goal space"', 'goto goal space',
                                  'goto 12 90', 'gotoRouteGoal r x', 'goto "goal space" -90'])
def test_a_goal_that_the_robot_has_passes_in_every_spelling(guard, text):
    guard.list_goals(['12', 'X', 'goal space'])
    passes(guard, text)


@pytest.mark.parametrize('text', ['goto 1', 'goto 13 12', 'gotoRouteGoal 12 r'])
def test_a_goal_that_the_robot_lacks_is_refused(guard, text):
    guard.list_goals(['12'])
    assert 'no goal "' in reason(guard, text)


def test_until_the_robot_has_listed_its_goals_any_goal_may_be_tried(guard):
    passes(guard, 'goto 1')


def test_a_robot_that_lists_no_goals_at_all_is_asked_itself(guard):
    guard.list_goals([])
    passes(guard, 'goto 1')


LOCALIZE = ('localizeToPoint 1 2 3', 'localizeAtGoal 12', 'LocalizeToPoint 1 2 3')


@pytest.mark.parametrize('text', LOCALIZE)
@pytest.mark.parametrize('state', [MotionState.DRIVING, MotionState.STOPPING, MotionState.DOCKING,
                                   MotionState.UNDOCKING])
def test_a_robot_that_drives_is_not_localized(guard, text, state):
    guard.motion = RobotMotion(DriveMemory(0), state, False)
    assert 'the robot drives: stop it first' in reason(guard, text)
    passes(guard, 'goto 12')


@pytest.mark.parametrize('text', LOCALIZE)
@pytest.mark.parametrize('state', [MotionState.STANDING, MotionState.DOCKED, MotionState.UNKNOWN,
                                   MotionState.MANUAL])
def test_a_robot_that_stands_or_that_a_person_drives_is_localized(guard, text, state):
    guard.motion = RobotMotion(DriveMemory(0), state, False)
    passes(guard, text)


def test_a_robot_that_was_just_told_to_drive_is_not_localized_until_the_drive_ends(guard):
    """The robot's status shows the drive only a moment later."""
    bench = Bench()
    bench.status('Docked')
    bench.drive(ROUTE, 'goto 12')
    for lines in ((), ('Going to 12',)):
        bench.robot(*lines)
        guard.motion = bench.records.motion
        assert 'the robot drives' in reason(guard, LOCALIZE[0])
    bench.robot('Arrived at 12')
    guard.motion = bench.records.motion
    passes(guard, LOCALIZE[0])
