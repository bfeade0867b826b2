"""Knowledge of the last goal, from the outcome, or from the status if the outcome is lost."""
from __future__ import annotations

import math

import pytest

from omron_ld90.bridge.events import CommandEnded, Ending, Motion, RobotSeen
from omron_ld90.bridge.goal_tracker import (
    REASON_DELAY,
    GoalTracker,
    Knowledge,
    TakenOver,
)
from omron_ld90.bridge.own_goals import DOCK

HERE, THERE = (0.0, 0.0), (3.0, 0.0)
LONG_AGO = -math.inf


def sent(goal: str = '12', before: Motion = Motion.STANDING, previous: str = '') -> GoalTracker:
    """A tracker whose command, number 1, was given at time 0 to a robot that did `before`."""
    tracker = GoalTracker()
    tracker.goals.remember(previous)
    tracker.located(HERE)
    tracker.seen(RobotSeen(0, before, previous), 0.0, LONG_AGO)
    tracker.send(goal, f'goto {goal}')
    assert tracker.give_again
    tracker.given(1)
    return tracker


def arrived() -> GoalTracker:
    tracker = sent()
    tracker.ended(CommandEnded(1, Ending.SUCCEEDED), 5.0)
    return tracker


def doubtful(ending: Ending = Ending.LOST, **how) -> GoalTracker:
    tracker = sent(**how)
    tracker.ended(CommandEnded(1, ending, 'the link broke'), 1.0)
    assert tracker.is_doubtful
    return tracker


def show(tracker: GoalTracker, motion: Motion, goal: str = '', link_stands_since: float = LONG_AGO,
         begin: float = 2.0, times: int = 4) -> None:
    """The robot shows this status, twice a second."""
    for count in range(times):
        tracker.seen(RobotSeen(0, motion, goal), begin + 0.5 * count, link_stands_since)


class TestOutcomes:
    """Outcomes that the controller reports."""

    def test_the_arrival(self):
        tracker = sent()
        tracker.ended(CommandEnded(1, Ending.SUCCEEDED), 5.0)
        assert tracker.reached
        assert tracker.goal == '12'

    def test_a_failure_in_its_own_words(self):
        tracker = sent()
        tracker.ended(CommandEnded(1, Ending.FAILED, 'Failed going to goal'), 5.0)
        assert tracker.failure.reason.text == 'Failed going to goal'

    @pytest.mark.parametrize('ending', [Ending.INTERRUPTED, Ending.CANCELLED])
    def test_an_interruption_is_somebody_elses_unless_an_emergency_stop_follows(self, ending):
        tracker = sent()
        tracker.ended(CommandEnded(1, ending, 'replaced by "goto 3"'), 5.0)
        tracker.check_clock(5.4)
        assert tracker.failure is None
        tracker.check_clock(5.6)
        assert isinstance(tracker.failure, TakenOver)

    def test_only_the_last_command_counts(self):
        tracker = sent()
        tracker.send('14', 'goto 14')
        tracker.given(2)
        for ending in Ending:
            tracker.ended(CommandEnded(1, ending), 5.0)
        assert (tracker.reached, tracker.failure, tracker.knowledge) == (
            False, None, Knowledge.AWAITED)

    def test_as_long_as_the_outcome_is_awaited_the_status_decides_nothing(self):
        tracker = sent()
        for motion, goal in ((Motion.GOING, '99'), (Motion.STANDING, ''), (Motion.ARRIVED, '12')):
            show(tracker, motion, goal)
        assert (tracker.reached, tracker.failure) == (False, None)

    def test_a_drive_that_was_overruled_is_somebody_elses_robot(self):
        tracker = sent()
        tracker.ended(CommandEnded(1, Ending.OVERRULED, 'another command came first'), 4.0)
        assert tracker.is_doubtful
        tracker.check_clock(4.0 + 2 * REASON_DELAY)
        assert isinstance(tracker.failure, TakenOver)

    def test_unless_its_epoch_ended_with_the_controllers_last_process(self):
        tracker = sent()
        tracker.ended(CommandEnded(1, Ending.OVERRULED, 'the controller was started'), 4.0)
        tracker.goes_on(4.1)
        tracker.check_clock(9.0)
        assert tracker.failure is None
        assert tracker.knowledge is Knowledge.DOUBTFUL


class TestLostOutcome:
    """The link or the controller was lost, so the robot's status decides."""

    def test_a_robot_on_its_way_is_watched_until_it_arrives(self):
        tracker = doubtful()
        show(tracker, Motion.GOING, '12')
        assert tracker.knowledge is Knowledge.WATCHED
        show(tracker, Motion.ARRIVED, '12', begin=9.0, times=1)
        assert tracker.reached
        assert not tracker.give_again

    def test_an_arrival_in_the_meantime_counts(self):
        tracker = doubtful()
        show(tracker, Motion.ARRIVED, '12')
        assert tracker.reached

    def test_a_robot_that_leaves_the_dock_is_on_its_way(self):
        tracker = doubtful(before=Motion.DOCKED)
        show(tracker, Motion.UNDOCKING)
        assert tracker.knowledge is Knowledge.WATCHED

    def test_a_robot_that_docks_is_watched_until_it_is_docked(self):
        tracker = doubtful(goal=DOCK)
        show(tracker, Motion.GOING, 'Charger 1')
        show(tracker, Motion.DOCKING, begin=5.0)
        assert not tracker.reached
        show(tracker, Motion.DOCKED, begin=9.0, times=1)
        assert tracker.reached

    @pytest.mark.parametrize('motion, goal', [(Motion.GOING, '10'), (Motion.ARRIVED, '10')])
    def test_a_robot_still_about_its_previous_goal_never_heard_of_it(self, motion, goal):
        tracker = doubtful(before=Motion.GOING, previous='10')
        show(tracker, motion, goal)
        assert tracker.give_again

    def test_a_robot_about_an_earlier_goal_heard_of_none_after_it(self):
        tracker = sent('12')
        show(tracker, Motion.GOING, '12', begin=1.0, times=1)
        for number, goal in enumerate(('10', '8'), 2):  # while the controller is suspended
            tracker.send(goal, f'goto {goal}')
            tracker.given(number)
        tracker.ended(CommandEnded(3, Ending.LOST, 'not heard'), 2.0)
        show(tracker, Motion.ARRIVED, '12', begin=2.5)
        assert tracker.failure is None
        assert tracker.give_again

    def test_a_goal_from_before_one_that_was_heard_is_not_ours_any_more(self):
        tracker = sent('12', previous='14')
        show(tracker, Motion.GOING, '12', begin=1.0, times=1)
        for number, goal in enumerate(('10', '8'), 2):
            tracker.send(goal, f'goto {goal}')
            tracker.given(number)
            show(tracker, Motion.GOING, goal, begin=float(number), times=1)
        assert {name for name in ('8', '9', '10', '12') if name in tracker.goals} == {'8', '10'}

    @pytest.mark.parametrize('motion', [Motion.ARRIVED, Motion.STANDING, Motion.DOCKED])
    def test_a_robot_that_stands_where_it_stood_never_heard_of_it(self, motion):
        tracker = doubtful(before=motion)
        show(tracker, motion)
        assert tracker.give_again

    @pytest.mark.parametrize('motion', [Motion.ARRIVED, Motion.DOCKED])
    def test_a_robot_that_stood_and_says_now_that_it_stops_was_stopped_by_somebody(self, motion):
        tracker = doubtful(Ending.NEVER_SENT, before=motion)
        show(tracker, Motion.STOPPING)
        assert not tracker.give_again
        show(tracker, Motion.STANDING, begin=5.0)
        assert isinstance(tracker.failure, TakenOver)
        assert not tracker.give_again

    @pytest.mark.parametrize('before', [Motion.ARRIVED, Motion.STANDING])
    def test_a_robot_that_stands_elsewhere_was_stopped_by_somebody(self, before):
        tracker = doubtful(before=before)
        tracker.located(THERE)
        show(tracker, Motion.STANDING)
        assert isinstance(tracker.failure, TakenOver)
        assert not tracker.give_again

    def test_a_robot_going_to_a_goal_that_is_not_ours_obeys_somebody_else(self):
        tracker = doubtful(before=Motion.GOING, previous='10')
        show(tracker, Motion.GOING, '99', times=1)
        assert isinstance(tracker.failure, TakenOver)

    def test_nothing_is_given_before_the_link_stands_for_a_status(self):
        tracker = doubtful(before=Motion.ARRIVED)
        show(tracker, Motion.ARRIVED, link_stands_since=math.inf, times=20)
        assert not tracker.give_again
        show(tracker, Motion.ARRIVED, link_stands_since=20.0, begin=20.5, times=1)
        assert not tracker.give_again
        show(tracker, Motion.ARRIVED, link_stands_since=20.0, begin=21.0, times=1)
        assert tracker.give_again

    def test_a_status_from_before_the_loss_decides_nothing(self):
        tracker = doubtful(before=Motion.ARRIVED)
        show(tracker, Motion.ARRIVED, begin=1.5, times=1)
        assert not tracker.give_again

    def test_not_even_that_the_robot_obeys(self):
        tracker = doubtful()
        show(tracker, Motion.ARRIVED, '12', begin=1.5, times=1)
        assert not tracker.reached
        show(tracker, Motion.ARRIVED, '12', begin=2.0, times=1)
        assert tracker.reached

    def test_a_command_that_was_never_sent_cannot_be_under_way(self):
        tracker = doubtful(ending=Ending.NEVER_SENT, before=Motion.GOING, previous='10')
        show(tracker, Motion.GOING, '10')
        assert tracker.give_again

    def test_a_robot_on_its_way_to_a_goal_that_it_was_never_sent_to_obeys_somebody_else(self):
        tracker = doubtful(ending=Ending.NEVER_SENT)
        show(tracker, Motion.GOING, '12', times=1)
        assert tracker.failure is None, 'this must need more than one status'
        show(tracker, Motion.GOING, '12', begin=3.0)
        assert isinstance(tracker.failure, TakenOver)

    def test_what_it_did_for_somebody_before_the_command_it_may_show_for_a_moment(self):
        tracker = GoalTracker()
        tracker.located(HERE)
        tracker.seen(RobotSeen(0, Motion.GOING, '99'), 0.0, LONG_AGO)
        tracker.send('12', 'goto 12')
        tracker.given(1)
        tracker.ended(CommandEnded(1, Ending.LOST), 1.0)
        show(tracker, Motion.GOING, '99', times=1)
        assert tracker.failure is None
        show(tracker, Motion.GOING, '99', begin=3.0, times=1)
        assert isinstance(tracker.failure, TakenOver)

    @pytest.mark.parametrize('shown', [Motion.STOPPING, Motion.UNKNOWN])
    def test_a_robot_that_shows_nothing_clear_is_waited_for(self, shown):
        tracker = doubtful()
        tracker.located(THERE)
        show(tracker, shown, times=20)
        assert (tracker.failure, tracker.give_again) == (None, False)

    @pytest.mark.parametrize('before, shown', [
        (Motion.UNKNOWN, [Motion.UNKNOWN]), (Motion.STANDING, [Motion.UNKNOWN]),
        (Motion.STOPPING, [Motion.STOPPING, Motion.STANDING])])
    def test_unless_it_showed_no_more_when_it_was_sent_off_and_has_not_moved(self, before, shown):
        tracker = doubtful(before=before)
        for count, motion in enumerate(shown):
            show(tracker, motion, begin=2.0 + 2.0 * count)
        assert tracker.failure is None
        assert tracker.give_again

    def test_one_that_showed_nothing_clear_and_is_driven_now_obeys_somebody(self):
        tracker = doubtful(before=Motion.UNKNOWN)
        show(tracker, Motion.BY_HAND)
        assert isinstance(tracker.failure, TakenOver)
        assert not tracker.give_again

    def test_what_was_strange_before_a_command_was_given_again_counts_no_more(self):
        tracker = doubtful(before=Motion.ARRIVED, previous='10')
        show(tracker, Motion.BY_HAND, times=1)
        show(tracker, Motion.ARRIVED, '10', begin=2.5)
        assert tracker.give_again
        tracker.given(2)
        tracker.ended(CommandEnded(2, Ending.LOST), 9.0)
        show(tracker, Motion.BY_HAND, begin=10.5, times=1)
        assert tracker.failure is None

    @pytest.mark.parametrize('motion, goal', [
        (Motion.ARRIVED, '99'), (Motion.DOCKED, ''), (Motion.FAILED, '99')])
    def test_a_watched_robot_that_arrives_elsewhere_was_sent_there_by_somebody(self, motion, goal):
        tracker = doubtful()
        show(tracker, Motion.GOING, '12')
        show(tracker, motion, goal, begin=5.0)
        assert not tracker.reached
        assert isinstance(tracker.failure, TakenOver)

    def test_without_a_goal_nothing_is_doubtful_after_a_restart(self):
        tracker = GoalTracker()
        tracker.resume(None, 0.0)
        assert not tracker.is_doubtful

    def test_a_robot_that_rests_as_before_but_was_stopped_meanwhile_heard_somebody(self):
        tracker = doubtful(ending=Ending.NEVER_SENT)
        show(tracker, Motion.STOPPING, begin=1.5, times=1)
        show(tracker, Motion.STANDING)
        assert not tracker.give_again
        assert isinstance(tracker.failure, TakenOver)

    def test_a_failed_drive_fails(self):
        tracker = doubtful()
        show(tracker, Motion.FAILED, '12')
        assert tracker.failure.reason.text == 'Failed going to 12'

    def test_a_watched_robot_that_shows_something_else_for_an_instant_is_still_ours(self):
        tracker = doubtful()
        show(tracker, Motion.GOING, '12')
        show(tracker, Motion.STANDING, begin=5.0, times=1)
        show(tracker, Motion.GOING, '12', begin=5.5)
        assert tracker.failure is None
        show(tracker, Motion.STANDING, begin=9.0, times=1)
        assert tracker.failure is None, 'two separate instants must not add up'
        show(tracker, Motion.STANDING, begin=9.5)
        assert isinstance(tracker.failure, TakenOver)

    def test_a_robot_that_names_no_goals_is_watched_too(self):
        tracker, nameless = sent(), RobotSeen(0, Motion.GOING)
        tracker.seen(nameless, 0.5, LONG_AGO)
        tracker.ended(CommandEnded(1, Ending.LOST), 1.0)
        show(tracker, Motion.GOING)
        assert tracker.knowledge is Knowledge.WATCHED
        assert tracker.failure is None
