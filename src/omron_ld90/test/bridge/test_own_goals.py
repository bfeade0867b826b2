"""Decides if the robot's goal is ours or another giver's."""
from __future__ import annotations

import pytest

from omron_ld90.bridge.events import Motion, RobotSeen
from omron_ld90.bridge.own_goals import DOCK, OwnGoals


def sent(*goals: str) -> OwnGoals:
    own = OwnGoals()
    for goal in goals:
        own.send(goal)
    return own


def seen(motion: Motion, goal: str = '') -> RobotSeen:
    return RobotSeen(0, motion, goal)


@pytest.mark.parametrize('motion, goal, obeyed', [
    (Motion.GOING, '12', True), (Motion.ARRIVED, '12', True), (Motion.FAILED, '12', True),
    (Motion.UNDOCKING, '', True), (Motion.GOING, '10', False), (Motion.STANDING, '', False),
    (Motion.DOCKING, '', False)])
def test_the_last_command_is_obeyed_by_who_goes_to_its_goal(motion, goal, obeyed):
    own = sent('10', '12')
    assert own.is_obeyed(seen(motion, goal)) is obeyed
    assert own.is_earlier_obeyed(seen(motion, goal)) is (goal == '10')


@pytest.mark.parametrize('motion, goal, obeyed', [
    (Motion.DOCKING, '', True), (Motion.DOCKED, '', True), (Motion.GOING, 'Charger 1', True),
    (Motion.GOING, '14', False), (Motion.UNDOCKING, '', False)])
def test_the_dock_is_gone_to_under_any_name_but_that_of_a_vertex(motion, goal, obeyed):
    assert sent(DOCK).is_obeyed(seen(motion, goal)) is obeyed


def test_the_last_goal_is_known_also_after_its_end():
    own = sent(DOCK)
    own.end()
    assert own.current is None
    assert own.last == DOCK


def test_goals_on_the_way_are_ours_as_long_as_their_command():
    own = OwnGoals()
    own.send('14', ['12', '13'])
    assert own.is_obeyed(seen(Motion.GOING, '13'))
    assert '13' in own
    own.send('16')
    assert '14' in own
    assert '13' not in own


def test_once_the_last_goal_is_shown_only_the_one_before_may_still_come():
    own = sent('8', '10', '12')
    assert '8' in own
    own.seen(seen(Motion.GOING, '12'), is_awaited=True)
    assert '8' not in own
    assert '10' in own


def test_a_robot_that_failed_to_go_to_a_goal_has_not_heard_of_it_again_nor_obeys_it():
    own = sent('8', '10', '12')
    own.seen(seen(Motion.FAILED, '12'), is_awaited=True)
    assert '8' in own
    assert not own.is_earlier_obeyed(seen(Motion.FAILED, '8'))


def test_of_very_many_goals_that_the_robot_never_shows_the_last_ones_are_remembered():
    own = sent(*map(str, range(100)))
    assert '80' in own
    assert '70' not in own


def test_a_restarted_bridge_remembers_one_goal():
    own = OwnGoals()
    own.remember('10')
    own.resume('12')
    assert (own.last, '10' in own) == ('12', True)
    own.remember('')
    assert '10' not in own


def test_how_a_robot_shows_a_drive_that_is_not_awaited_tells_nothing_of_ours():
    own, nameless = sent('12'), seen(Motion.GOING)
    own.seen(nameless, is_awaited=False)
    assert not own.is_obeyed(nameless)


def test_a_robot_that_never_names_where_it_goes_may_go_where_we_sent_it():
    own, nameless = sent('12'), seen(Motion.GOING)
    own.seen(nameless, is_awaited=True)
    assert own.is_obeyed(nameless)
    assert own.is_obeyed(nameless)
    own.seen(seen(Motion.GOING, '12'), is_awaited=True)
    own.seen(nameless, is_awaited=True)
    assert not own.is_obeyed(nameless)
    assert not own.is_obeyed(nameless)
