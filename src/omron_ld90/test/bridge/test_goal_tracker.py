"""How the drive to the last goal ends: by its result, or by `motion` if the result is lost."""
from __future__ import annotations

import pytest

from omron_ld90.bridge.events import CommandEnded, Ending, Fate, Motion
from omron_ld90.bridge.goal_tracker import DOCK, REASON_DELAY, GoalTracker, TakenOver

HERE, THERE = (0.0, 0.0), (3.0, 0.0)


def sent(goal: str = '12') -> GoalTracker:
    """A tracker whose command, number 1, was given."""
    tracker = GoalTracker()
    tracker.send(goal, f'goto {goal}')
    tracker.word.give(1, 0)
    return tracker


def ended(ending: Ending, text: str = '', goal: str = '12') -> GoalTracker:
    """A tracker whose command has ended so at 5 s."""
    tracker = sent(goal)
    tracker.ended(CommandEnded(1, ending, text), 5.0)
    return tracker


def test_the_arrival():
    tracker = ended(Ending.SUCCEEDED)
    assert (tracker.reached, tracker.goal) == (True, '12')


def test_a_failure_in_its_own_words():
    assert ended(Ending.FAILED, 'Failed going to goal').failure.reason.text == (
        'Failed going to goal')


@pytest.mark.parametrize('ending', [Ending.INTERRUPTED, Ending.CANCELLED, Ending.OVERRULED])
def test_an_interruption_is_somebody_elses_unless_an_emergency_stop_follows(ending):
    tracker = ended(ending, 'replaced by "goto 3"')
    assert tracker.is_doubtful
    tracker.check_clock(5.0 + 0.8 * REASON_DELAY)
    assert tracker.failure is None
    tracker.check_clock(5.0 + 1.2 * REASON_DELAY)
    assert isinstance(tracker.failure, TakenOver)


def test_a_drive_that_was_overruled_by_a_restart_of_the_controller_is_given_again():
    tracker = ended(Ending.OVERRULED, 'the controller was started')
    tracker.goes_on(5.1)
    tracker.check_clock(9.0)
    assert tracker.failure is None
    assert tracker.word.due(True, 5.1)


def test_one_that_was_interrupted_is_not():
    tracker = ended(Ending.INTERRUPTED)
    tracker.goes_on(5.1)
    tracker.check_clock(9.0)
    assert isinstance(tracker.failure, TakenOver)


def test_only_the_last_command_counts():
    tracker = sent()
    tracker.send('14', 'goto 14')
    tracker.word.give(2, 0)
    for ending in Ending:
        tracker.ended(CommandEnded(1, ending), 5.0)
    assert (tracker.reached, tracker.failure, tracker.is_doubtful) == (False, None, False)


@pytest.mark.parametrize('told_before', [False, True])
def test_the_arrival_of_a_lost_drive_is_told_by_the_controller(told_before):
    tracker = sent()
    if told_before:
        tracker.told(1, Fate.COMPLETED, 4.0)
    tracker.ended(CommandEnded(1, Ending.LOST), 5.0)
    if not told_before:
        assert tracker.is_doubtful
        tracker.told(1, Fate.OBEYED, 6.0)
        assert not tracker.reached
        tracker.told(1, Fate.COMPLETED, 7.0)
    assert (tracker.reached, tracker.is_doubtful) == (True, False)


def test_so_is_its_failure():
    tracker = ended(Ending.LOST)
    tracker.told(1, Fate.FAILED, 6.0)
    assert tracker.failure.reason.text == 'the robot failed to reach its goal'


@pytest.mark.parametrize('told, reached, given_again', [
    ((7, Fate.COMPLETED), True, False), ((7, Fate.OBEYED), False, False),
    ((7, Fate.NOT_OBEYED), False, True), ((6, Fate.COMPLETED), False, True)])
def test_after_a_restart_the_controller_tells_what_became_of_the_drive(
        told, reached, given_again):
    tracker = GoalTracker()
    tracker.told(*told, 0.0)
    tracker.resume('12', 'goto 12', 7, 1.0)
    assert (tracker.reached, tracker.word.due(True, 1.0)) == (reached, given_again)


def test_after_a_restart_a_drive_that_was_not_given_yet_is_given():
    tracker = GoalTracker()
    tracker.told(6, Fate.COMPLETED, 0.0)
    tracker.resume('12', 'goto 12', 0, 1.0)
    assert (tracker.word.due(True, 1.0), tracker.is_doubtful) == (True, False)


def test_after_a_restart_a_newer_drive_than_the_known_one_makes_the_goal_unknown():
    tracker = GoalTracker()
    tracker.told(8, Fate.OBEYED, 0.0)
    tracker.resume('12', 'goto 12', 7, 1.0)
    assert (tracker.goal, tracker.is_doubtful, tracker.word.due(True, 1.0)) == (None, False, False)


def test_a_robot_that_has_docked():
    assert ended(Ending.SUCCEEDED, goal=DOCK).has_docked
    assert not ended(Ending.SUCCEEDED).has_docked


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
    tracker.ended(CommandEnded(1, Ending.SUCCEEDED), 5.0)
    for place, motion, rested in ((HERE, Motion.GOING, 0), (HERE, Motion.ARRIVED, 1),
                                  (HERE, Motion.ARRIVED, 2), (THERE, Motion.ARRIVED, 0)):
        tracker.located(place, motion)
        assert tracker.rested_at_goal == rested
