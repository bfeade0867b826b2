"""A stop is owed until the robot has obeyed it or somebody else drives it."""
from __future__ import annotations

import pytest

from omron_ld90.bridge.events import CommandEnded, Ending, Motion, RobotSeen
from omron_ld90.bridge.stop_duty import StopDuty

OURS = '12'


def given(number: int = 1, now: float = 0.0) -> StopDuty:
    """A duty whose stop was given at once."""
    duty = StopDuty()
    duty.require(now)
    assert duty.is_due(False, now), 'the first time it is given whatever is known of the link'
    duty.given(number, now)
    return duty


def see(duty: StopDuty, motion: Motion, goal: str = '', times: int = 2, begin: float = 2.0) -> None:
    on_our_way = goal == OURS if motion is Motion.GOING else None
    for count in range(times):
        duty.seen(RobotSeen(0, motion, goal), on_our_way, begin + count)


@pytest.mark.parametrize('ending', [Ending.SUCCEEDED, Ending.INTERRUPTED,
                                    Ending.EMERGENCY_STOPPED])
def test_obeyed_or_overtaken_it_is_over(ending):
    duty = given()
    duty.ended(CommandEnded(1, ending))
    assert not duty.owed


@pytest.mark.parametrize('ending', [Ending.LOST, Ending.NEVER_SENT, Ending.FAILED,
                                    Ending.CANCELLED])
def test_what_came_to_nothing_is_tried_again_once_the_link_stands(ending):
    duty = given()
    duty.ended(CommandEnded(1, ending, 'why not'))
    assert duty.owed
    assert duty.problem == 'why not'
    assert not duty.is_due(False, 9.0)
    assert not duty.is_due(True, 0.5), 'not more often than once a second'
    assert duty.is_due(True, 1.0)


def test_an_attempt_that_ended_without_a_word_is_told_by_how_it_ended():
    duty = given()
    duty.ended(CommandEnded(1, Ending.LOST))
    assert duty.problem == 'lost'


def test_whoever_wants_a_stop_anew_gets_one_whatever_became_of_the_last():
    duty = given()
    duty.require(0.1)
    assert duty.is_due(False, 0.1)


def test_an_attempt_under_way_is_waited_for():
    assert not given().is_due(True, 60.0)


def test_the_end_of_another_command_means_nothing():
    duty = given(number=4)
    duty.ended(CommandEnded(3, Ending.SUCCEEDED))
    assert duty.owed


@pytest.mark.parametrize('motion, goal', [
    (Motion.STANDING, ''), (Motion.ARRIVED, '12'), (Motion.FAILED, '12'), (Motion.DOCKED, ''),
    (Motion.GOING, '99'), (Motion.GOING, '')])
def test_a_robot_seen_at_rest_or_on_another_way_needs_no_stop(motion, goal):
    duty = given()
    see(duty, motion, goal)
    assert not duty.owed


@pytest.mark.parametrize('motion, goal', [
    (Motion.GOING, '12'), (Motion.UNKNOWN, ''), (Motion.DOCKING, ''), (Motion.UNDOCKING, '')])
def test_a_robot_that_may_still_be_on_our_way_needs_it(motion, goal):
    duty = given()
    see(duty, motion, goal, times=5)
    assert duty.owed


def test_one_status_alone_or_too_early_proves_nothing():
    duty = given()
    see(duty, Motion.STANDING, times=1)
    assert duty.owed
    duty = given()
    see(duty, Motion.STANDING, times=2, begin=-1.5)
    assert duty.owed


def test_a_robot_that_is_seen_on_our_way_in_between_is_not_at_rest():
    duty = given()
    see(duty, Motion.STANDING, times=1, begin=2.0)
    see(duty, Motion.GOING, '12', times=1, begin=3.0)
    see(duty, Motion.STANDING, times=1, begin=4.0)
    assert duty.owed


class TestLookingFirst:
    """After a restart somebody else may drive the robot by now."""

    def test_a_robot_on_our_way_is_stopped_at_once(self):
        duty = StopDuty()
        duty.require(0.0, look_first=5.0)
        assert not duty.is_due(True, 1.0)
        see(duty, Motion.GOING, '12', times=1)
        assert duty.is_due(True, 2.0)

    def test_a_robot_on_another_way_is_not(self):
        duty = StopDuty()
        duty.require(0.0, look_first=5.0)
        see(duty, Motion.GOING, '99')
        assert not duty.is_due(True, 9.0)

    def test_a_silent_robot_is_stopped_after_all(self):
        duty = StopDuty()
        duty.require(0.0, look_first=5.0)
        assert duty.is_due(True, 5.0)
