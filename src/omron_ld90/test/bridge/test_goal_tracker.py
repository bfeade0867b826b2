"""The drive to the last goal ends with its result, or by `motion` if the result is lost."""
from __future__ import annotations

import pytest

from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import CommandFate
from omron_ld90.bridge.events import CommandEnded
from omron_ld90.bridge.goal_tracker import DOCK, GoalTracker

HERE, THERE = (0.0, 0.0), (3.0, 0.0)


def sent(goal: str = '12') -> GoalTracker:
    """Returns a tracker whose command was given with the number 1."""
    tracker = GoalTracker()
    tracker.send(goal, f'goto {goal}')
    tracker.word.give(1, 0)
    return tracker


def ended(ending: Outcome, text: str = '', goal: str = '12') -> GoalTracker:
    """Returns a tracker whose command has ended in this way at 5 s."""
    tracker = sent(goal)
    tracker.ended(CommandEnded(1, ending, text), 5.0)
    return tracker


def test_the_arrival():
    tracker = ended(Outcome.SUCCEEDED)
    assert (tracker.reached, tracker.goal) == (True, '12')


def test_a_failure_in_its_own_words():
    assert ended(Outcome.FAILED, 'Failed going to goal').failure.reason.text == (
        'Failed going to goal')


@pytest.mark.parametrize('ending', [
    Outcome.INTERRUPTED, Outcome.CANCELLED, Outcome.OVERRULED, Outcome.LOST])
@pytest.mark.parametrize('told_before', [False, True])
@pytest.mark.parametrize('fate', CommandFate)
def test_the_controller_tells_what_became_of_a_drive_that_did_not_end_by_itself(
        ending, told_before, fate):
    tracker = sent() if told_before else ended(ending, 'replaced by "goto 3"')
    tracker.told(1, fate, 5.1)
    if told_before:
        tracker.ended(CommandEnded(1, ending), 5.2)
    assert tracker.reached is (fate is CommandFate.COMPLETED)
    assert (tracker.failure is not None) is (fate is CommandFate.FAILED)
    assert tracker.word.due(True, 5.3) is (fate is CommandFate.NOT_OBEYED)
    assert tracker.awaits_motion is (
        fate in (CommandFate.GIVEN, CommandFate.OBEYED, CommandFate.UNKNOWN))


def test_only_the_last_command_counts():
    tracker = sent()
    tracker.send('14', 'goto 14')
    tracker.word.give(2, 0)
    for ending in Outcome:
        tracker.ended(CommandEnded(1, ending), 5.0)
    assert (tracker.reached, tracker.failure, tracker.awaits_motion) == (False, None, False)


@pytest.mark.parametrize('told_before', [False, True])
def test_the_arrival_of_a_lost_drive_is_told_by_the_controller(told_before):
    tracker = sent()
    if told_before:
        tracker.told(1, CommandFate.COMPLETED, 4.0)
    tracker.ended(CommandEnded(1, Outcome.LOST), 5.0)
    if not told_before:
        assert tracker.awaits_motion
        tracker.told(1, CommandFate.OBEYED, 6.0)
        assert not tracker.reached
        tracker.told(1, CommandFate.COMPLETED, 7.0)
    assert (tracker.reached, tracker.awaits_motion) == (True, False)


def test_so_is_its_failure():
    tracker = ended(Outcome.LOST)
    tracker.told(1, CommandFate.FAILED, 6.0)
    assert tracker.failure.reason.text == 'the robot failed to reach its goal'


@pytest.mark.parametrize('told, reached, given_again', [
    ((7, CommandFate.COMPLETED), True, False), ((7, CommandFate.OBEYED), False, False),
    ((7, CommandFate.NOT_OBEYED), False, True), ((6, CommandFate.COMPLETED), False, True)])
def test_after_a_restart_the_controller_tells_what_became_of_the_drive(
        told, reached, given_again):
    tracker = GoalTracker()
    tracker.told(*told, 0.0)
    tracker.resume('12', 'goto 12', 7, 1.0)
    assert (tracker.reached, tracker.word.due(True, 1.0)) == (reached, given_again)


def test_after_a_restart_a_drive_that_was_not_given_yet_is_given():
    tracker = GoalTracker()
    tracker.told(6, CommandFate.COMPLETED, 0.0)
    tracker.resume('12', 'goto 12', 0, 1.0)
    assert (tracker.word.due(True, 1.0), tracker.awaits_motion) == (True, False)


def test_after_a_restart_a_newer_drive_than_the_known_one_makes_the_goal_unknown():
    tracker = GoalTracker()
    tracker.told(8, CommandFate.OBEYED, 0.0)
    tracker.resume('12', 'goto 12', 7, 1.0)
    assert tracker.goal is None
    assert (tracker.awaits_motion, tracker.word.due(True, 1.0)) == (False, False)


def test_a_robot_that_has_docked():
    assert ended(Outcome.SUCCEEDED, goal=DOCK).has_docked
    assert not ended(Outcome.SUCCEEDED).has_docked


def test_a_stop_takes_the_drive_back_and_a_new_route_takes_the_stop_back():
    tracker = sent()
    tracker.stop(3)
    assert (tracker.goal, tracker.word.command) == (None, 'stop')
    tracker.end()
    assert tracker.word.due(False, 6.0), 'the end of a drive is none of a stop'
    tracker.forget()
    assert not tracker.word.due(True, 60.0)


def test_locations_at_rest_count_from_the_arrival_on():
    tracker = sent()
    tracker.located(HERE)
    tracker.ended(CommandEnded(1, Outcome.SUCCEEDED), 5.0)
    going, arrived = ActivityKind.GOING_TO_GOAL, ActivityKind.ARRIVED_AT_GOAL
    for place, activity, rested in ((HERE, going, 0), (HERE, arrived, 1), (HERE, arrived, 2),
                                    (THERE, arrived, 0)):
        tracker.located(place, activity)
        assert tracker.rested_at_goal == rested
