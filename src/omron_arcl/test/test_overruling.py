"""What somebody gave before he could know of another's stop or drive must not pass that."""
from __future__ import annotations

import pytest

from omron_arcl import Outcome, parse_command
from omron_arcl.overruling import LATE, Overruled, Overruling

ROUTE, PERSON, OTHER = '/edges_to_vertices', '/rviz', '/joystick'


class Bench:
    """Commands given by nodes, with a clock of its own."""

    def __init__(self) -> None:
        self.now = 100.0
        self._overruling = Overruling(lambda: self.now)
        self.stopping, self.powered = self._overruling.stopping, self._overruling.powered

    def give(self, giver: str, text: str):
        return self._overruling.take(giver, parse_command(text))

    def cancel(self, motion, canceller: str) -> None:
        self._overruling.cancelled(motion, canceller)

    def end(self, motion, outcome: Outcome = Outcome.INTERRUPTED) -> None:
        self._overruling.ended(motion, outcome)


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.mark.parametrize('word', ['stop', 'goto 3', 'dock', 'gotoPoint 0 0 0'])
def test_a_drive_cannot_pass_what_somebody_else_gave_while_its_givers_last_was_under_way(
        bench, word):
    bench.give(ROUTE, 'goto 12')
    bench.give(PERSON, word)
    with pytest.raises(Overruled, match=f'"{word}" of {PERSON} came first'):
        bench.give(ROUTE, 'goto 14')


def test_it_is_refused_until_its_giver_has_heard_that_its_last_drive_is_over(bench):
    drive = bench.give(ROUTE, 'goto 12')
    bench.give(PERSON, 'stop')
    bench.now += 10.0  # a robot that brakes without a word
    with pytest.raises(Overruled):
        bench.give(ROUTE, 'goto 14')
    bench.end(drive)
    bench.now += LATE / 2
    with pytest.raises(Overruled):
        bench.give(ROUTE, 'goto 14')
    bench.now += LATE
    bench.give(ROUTE, 'goto 14')


def test_whoever_gave_the_last_word_may_go_on(bench):
    bench.give(ROUTE, 'goto 12')
    bench.give(PERSON, 'stop')
    bench.give(PERSON, 'goto 3')
    bench.give(PERSON, 'goto 4')


def test_a_route_replaces_its_own_drives_and_stops_itself(bench):
    bench.give(ROUTE, 'goto 12')
    bench.give(ROUTE, 'goto 14')
    bench.give(ROUTE, 'stop')
    bench.give(ROUTE, 'goto 16')


def test_who_has_no_drive_under_way_gives_a_new_word(bench):
    bench.give(PERSON, 'stop')
    bench.now += LATE
    bench.give(ROUTE, 'goto 12')
    bench.give(OTHER, 'goto 3')


def test_the_first_drive_of_a_route_does_not_pass_a_stop_of_the_same_moment_either(bench):
    bench.give(PERSON, 'stop')
    bench.now += LATE / 2
    with pytest.raises(Overruled, match=f'"stop" of {PERSON} came first'):
        bench.give(ROUTE, 'goto 12')


def test_the_stop_at_the_end_of_a_route_holds_back_nobody_else(bench):
    bench.end(bench.give(ROUTE, 'goto 12'), Outcome.FAILED)
    bench.now += LATE
    bench.give(ROUTE, 'stop')
    bench.give(PERSON, 'goto 3')


def test_a_stop_that_came_to_nothing_holds_back_no_first_drive(bench):
    bench.end(bench.give(PERSON, 'stop'), Outcome.LOST)
    bench.give(ROUTE, 'goto 12')


def test_a_drive_does_not_pass_a_stop_of_another_client_of_the_robot(bench):
    bench.stopping()
    with pytest.raises(Overruled, match='a stop of another client of the robot came first'):
        bench.give(ROUTE, 'goto 12')
    bench.now += LATE
    bench.give(ROUTE, 'goto 12')


def test_a_robot_that_obeys_our_stop_was_not_stopped_by_another_client(bench):
    stop = bench.give(ROUTE, 'stop')
    bench.now += 2 * LATE  # it says so late
    bench.stopping()
    bench.end(stop, Outcome.SUCCEEDED)
    bench.give(OTHER, 'goto 12')


@pytest.mark.parametrize('outcome', [Outcome.CANCELLED, Outcome.TIMED_OUT])
def test_nor_one_that_obeys_the_stop_after_a_cancellation_or_a_time_out(bench, outcome):
    drive = bench.give(ROUTE, 'goto 12')
    bench.now += 10.0
    if outcome is Outcome.CANCELLED:
        bench.cancel(drive, ROUTE)
    bench.end(drive, outcome)
    bench.stopping()
    bench.give(ROUTE, 'goto 14')


def test_a_robot_that_stops_for_an_instant_to_replace_a_drive_was_stopped_by_nobody(bench):
    bench.give(ROUTE, 'goto 12')
    bench.now += LATE / 2
    bench.stopping()
    bench.give(ROUTE, 'goto 14')


def test_a_robot_that_stops_by_itself_once_its_motors_are_on_was_stopped_by_nobody(bench):
    bench.powered()
    bench.stopping()
    bench.give(ROUTE, 'goto 12')


def test_between_two_drives_of_a_route_a_stop_is_not_passed_either(bench):
    bench.end(bench.give(ROUTE, 'goto 12'), Outcome.SUCCEEDED)
    bench.give(PERSON, 'stop')
    with pytest.raises(Overruled, match=f'"stop" of {PERSON} came first'):
        bench.give(ROUTE, 'goto 14')


def test_a_drive_that_ended_by_itself_is_not_overruled_by_another_drive_afterwards(bench):
    bench.end(bench.give(ROUTE, 'goto 12'), Outcome.SUCCEEDED)
    bench.give(PERSON, 'goto 3')
    bench.give(ROUTE, 'goto 14')


def test_a_drive_does_not_pass_what_another_client_of_the_robot_did_to_the_one_before(bench):
    bench.end(bench.give(ROUTE, 'goto 12'), Outcome.INTERRUPTED)
    with pytest.raises(Overruled, match='another client of the robot came first'):
        bench.give(ROUTE, 'goto 14')
    bench.now += LATE
    bench.give(ROUTE, 'goto 14')


@pytest.mark.parametrize('own', ['goto 14', 'stop'])
def test_what_a_route_interrupts_itself_overrules_it_not(bench, own):
    drive = bench.give(ROUTE, 'goto 12')
    bench.give(ROUTE, own)
    bench.end(drive, Outcome.INTERRUPTED)
    bench.give(ROUTE, 'goto 16')


def test_a_drive_cannot_pass_somebodys_cancellation_of_the_one_before(bench):
    drive = bench.give(ROUTE, 'goto 12')
    bench.cancel(drive, PERSON)
    with pytest.raises(Overruled, match=f'cancellation of {PERSON} came first'):
        bench.give(ROUTE, 'goto 14')
    bench.end(drive, Outcome.CANCELLED)
    bench.now += LATE
    bench.give(ROUTE, 'goto 14')


def test_who_cancels_his_own_drive_may_give_another(bench):
    bench.cancel(bench.give(ROUTE, 'goto 12'), ROUTE)
    bench.give(ROUTE, 'goto 14')


def test_a_stop_is_never_refused(bench):
    bench.give(ROUTE, 'goto 12')
    bench.give(PERSON, 'goto 3')
    bench.give(ROUTE, 'stop')


@pytest.mark.parametrize('outcome', [Outcome.NO_GOAL, Outcome.REJECTED, Outcome.UNKNOWN_COMMAND,
                                     Outcome.LOST])
def test_a_word_that_came_to_nothing_overrules_nobody(bench, outcome):
    bench.give(ROUTE, 'goto 12')
    bench.end(bench.give(PERSON, 'goto nowhere'), outcome)
    bench.give(ROUTE, 'goto 14')


def test_the_first_of_two_words_is_named(bench):
    bench.give(ROUTE, 'goto 12')
    bench.give(PERSON, 'goto 2')
    bench.give(OTHER, 'stop')
    with pytest.raises(Overruled, match=PERSON) as refused:
        bench.give(ROUTE, 'goto 14')
    assert refused.value.by.text == '"goto 2"'


def test_a_word_is_named_though_a_cancellation_or_the_end_of_the_drive_follows_it(bench):
    drive = bench.give(ROUTE, 'goto 12')
    bench.give(PERSON, 'goto 2')
    bench.cancel(drive, OTHER)
    bench.end(drive, Outcome.INTERRUPTED)
    with pytest.raises(Overruled, match=f'"goto 2" of {PERSON} came first'):
        bench.give(ROUTE, 'goto 14')


def test_a_word_that_came_to_nothing_undoes_no_other(bench):
    bench.give(ROUTE, 'goto 12')
    bench.give(PERSON, 'goto 2')
    bench.end(bench.give(OTHER, 'goto nowhere'), Outcome.NO_GOAL)
    with pytest.raises(Overruled, match=PERSON):
        bench.give(ROUTE, 'goto 14')


def test_a_stop_whose_end_was_lost_after_it_ended_a_drive_has_not_come_to_nothing(bench):
    drive, stop = bench.give(ROUTE, 'goto 12'), bench.give(PERSON, 'stop')
    bench.end(drive, Outcome.INTERRUPTED)
    bench.end(stop, Outcome.LOST)
    with pytest.raises(Overruled, match=PERSON):
        bench.give(ROUTE, 'goto 14')


@pytest.mark.parametrize('outcome', [Outcome.NO_GOAL, Outcome.REJECTED, Outcome.LOST])
def test_after_a_drive_of_its_own_that_came_to_nothing_a_route_is_interrupted_by_others(
        bench, outcome):
    drive = bench.give(ROUTE, 'goto 12')
    bench.end(bench.give(ROUTE, 'goto nowhere'), outcome)
    bench.end(drive, Outcome.INTERRUPTED)
    with pytest.raises(Overruled, match='another client of the robot came first'):
        bench.give(ROUTE, 'goto 14')


def test_of_two_drives_of_its_own_one_that_came_to_nothing_does_not_hide_the_other(bench):
    drive, nowhere = bench.give(ROUTE, 'goto 12'), bench.give(ROUTE, 'goto nowhere')
    bench.give(ROUTE, 'goto 14')
    bench.end(nowhere, Outcome.NO_GOAL)
    bench.end(drive, Outcome.INTERRUPTED)
    bench.give(ROUTE, 'goto 16')


def test_a_route_between_two_drives_passes_no_stop_of_whoever_drove_meanwhile(bench):
    bench.end(bench.give(ROUTE, 'goto 12'), Outcome.SUCCEEDED)
    bench.give(PERSON, 'goto 3')
    bench.give(PERSON, 'stop')
    with pytest.raises(Overruled, match=f'"stop" of {PERSON} came first'):
        bench.give(ROUTE, 'goto 14')


def test_a_robot_that_says_late_that_it_obeys_our_stop_was_stopped_by_us(bench):
    bench.give(ROUTE, 'stop')
    bench.now += 2 * LATE
    bench.give(OTHER, 'goto 12')
    bench.now += 2 * LATE
    bench.stopping()
    bench.give(ROUTE, 'goto 14')


def test_a_robot_that_stops_on_its_way_was_stopped_by_another_client(bench):
    bench.give(ROUTE, 'goto 12')
    bench.now += LATE
    bench.stopping()
    with pytest.raises(Overruled, match='a stop of another client of the robot came first'):
        bench.give(ROUTE, 'goto 14')


def test_so_was_one_that_stops_long_after_a_cancellation(bench):
    drive = bench.give(ROUTE, 'goto 12')
    bench.cancel(drive, ROUTE)
    bench.now += LATE
    bench.end(drive, Outcome.CANCELLED)
    bench.now += LATE
    bench.stopping()
    with pytest.raises(Overruled, match='a stop of another client of the robot came first'):
        bench.give(OTHER, 'goto 3')


@pytest.mark.parametrize('text', ['status', 'say hello', 'enableMotors', 'getGoals'])
def test_what_does_not_move_the_robot_is_no_word(bench, text):
    bench.give(ROUTE, 'goto 12')
    assert bench.give(PERSON, text) is None
    bench.give(ROUTE, 'goto 14')
