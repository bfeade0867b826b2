"""Which commands the controller lets through, and the reasons it gives for the others."""
from __future__ import annotations

import pytest

from omron_arcl import HelpList, InvalidCommand
from omron_arcl.guard import Guard


@pytest.fixture
def guard() -> Guard:
    return Guard(['motion', 'query'])


def reason(guard: Guard, text: str) -> str:
    with pytest.raises(InvalidCommand) as refused:
        guard.check(text)
    return str(refused.value)


@pytest.mark.parametrize('text', ['goto 12', 'stop', 'getGoals', 'localizeToPoint 1 2 3', 'STATUS'])
def test_motion_and_queries_pass(guard, text):
    assert guard.check(text).text == text


@pytest.mark.parametrize('text', ['shutdown', 'ShutDown', 'configStart', 'quit', 'say hello',
                                  'connectOutgoing 10.0.0.1 7179', 'abracadabra', '"shutdown"'])
def test_everything_else_is_refused_with_the_way_to_allow_it(guard, text):
    assert '~allowed_commands' in reason(guard, text)


def test_a_command_can_be_allowed_by_name(guard):
    guard = Guard(['query', 'Say', 'newFangled'])
    guard.check('say hello')
    guard.check('newFangled')
    reason(guard, 'play a.wav')
    reason(guard, 'goto 12')
    assert guard.unknown_words() == {'newfangled'}


def test_a_shortcut_is_no_way_around_the_guard(guard):
    guard.help = HelpList({'shutdown': 'Powers off [sd]', 'goto': 'Goes'})
    assert 'dangerous' in reason(guard, 'sd')


def test_a_command_that_the_robot_does_not_have_is_refused(guard):
    guard.help = HelpList({'goto': 'Goes to a goal'})
    guard.check('goto 12')
    assert 'its own help list' in reason(guard, 'patrol r')


@pytest.mark.parametrize('text', ['goto 12', 'goto X', 'goto "goal space"', 'goto goal space',
                                  'goto 12 90', 'gotoRouteGoal r x', 'goto "goal space" -90'])
def test_a_goal_that_the_robot_has_passes_in_every_spelling(guard, text):
    guard.goals = frozenset({'12', 'x', 'goal space'})
    guard.check(text)


@pytest.mark.parametrize('text', ['goto 1', 'goto 13 12', 'gotoRouteGoal 12 r'])
def test_a_goal_that_the_robot_lacks_is_refused(guard, text):
    guard.goals = frozenset({'12'})
    assert 'no goal "' in reason(guard, text)


def test_until_the_robot_has_listed_its_goals_any_goal_may_be_tried(guard):
    guard.check('goto 1')
