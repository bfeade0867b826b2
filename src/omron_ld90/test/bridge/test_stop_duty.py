"""A stop is given until the controller has taken it; then the controller makes the robot obey."""
from __future__ import annotations

import pytest

from omron_ld90.bridge.events import CommandEnded, Ending
from omron_ld90.bridge.stop_duty import StopDuty


def given(number: int = 1, now: float = 0.0) -> StopDuty:
    """A stop duty whose stop was given at once."""
    duty = StopDuty()
    duty.require(7)
    assert duty.is_due(False, now), 'the first time it must be given regardless of the link'
    duty.given(number, now)
    return duty


@pytest.mark.parametrize('ending', [
    ending for ending in Ending if ending not in (Ending.LOST, Ending.NEVER_SENT)])
def test_what_the_controller_has_taken_is_its_own_duty(ending):
    duty = given()
    duty.ended(CommandEnded(1, ending))
    assert not duty.to_give


@pytest.mark.parametrize('ending', [Ending.LOST, Ending.NEVER_SENT])
def test_what_did_not_reach_it_is_tried_again_once_the_link_stands(ending):
    duty = given()
    duty.ended(CommandEnded(1, ending, 'why not'))
    assert duty.owed
    assert duty.problem == 'why not'
    assert duty.epoch == 7, 'the epoch that the stop must end'
    assert not duty.is_due(False, 9.0)
    assert not duty.is_due(True, 0.5), 'it may be given at most once a second'
    assert duty.is_due(True, 1.0)


def test_an_attempt_that_ended_without_a_word_is_told_by_how_it_ended():
    duty = given()
    duty.ended(CommandEnded(1, Ending.LOST))
    assert duty.problem == 'lost'


def test_whoever_wants_a_stop_anew_gets_one_whatever_became_of_the_last():
    duty = given()
    duty.require(8)
    assert duty.is_due(False, 0.1)


def test_an_attempt_under_way_is_waited_for():
    assert not given().is_due(True, 60.0)


def test_the_end_of_another_command_means_nothing():
    duty = given(number=4)
    duty.ended(CommandEnded(3, Ending.SUCCEEDED))
    assert duty.owed
