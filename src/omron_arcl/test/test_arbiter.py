"""Commands of several givers: what is allowed goes to the client, and nobody's word is passed."""
from __future__ import annotations

import threading

import pytest

from omron_arcl import ArclError, Execution, InvalidCommand, NotConnected, Outcome, parse_command
from omron_arcl.arbiter import Arbiter
from omron_arcl.guard import Guard
from omron_arcl.overruling import LATE, Overruled
from omron_arcl.replies import Motors, Stopping

ROUTE, PERSON = '/edges_to_vertices', '/rviz'


class Bench:
    """An arbiter, a client that only notes what it gives, and a clock."""

    def __init__(self) -> None:
        self.now = 100.0
        self.given, self.cancelled = [], []
        self.connected = True
        self.guard = Guard(['motion'])
        self.while_giving = lambda: None
        self.arbiter = Arbiter(self._execute, self.cancelled.append, self.guard, lambda: self.now)

    def _execute(self, text, check, on_end) -> Execution:
        command = parse_command(text)
        check(command)
        if not self.connected:
            raise NotConnected('no route to host')
        self.while_giving()
        self.given.append(text)
        return Execution(command, on_end=on_end)

    @staticmethod
    def end(execution: Execution, outcome: Outcome) -> None:
        execution.end(outcome, 'words')
        execution.announce()


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_what_is_allowed_is_given_and_its_giver_hears_how_it_ends(bench):
    results = []
    bench.end(bench.arbiter.execute('goto 12', ROUTE, on_end=results.append), Outcome.FAILED)
    assert bench.given == ['goto 12']
    assert [result.outcome for result in results] == [Outcome.FAILED]


def test_what_is_not_allowed_is_not_given_and_is_nobodys_word(bench):
    bench.arbiter.execute('goto 12', ROUTE)
    with pytest.raises(InvalidCommand):
        bench.arbiter.execute('shutdown', PERSON)
    bench.arbiter.execute('goto 14', ROUTE)
    assert bench.given == ['goto 12', 'goto 14']


def test_a_drive_given_before_its_giver_could_know_of_a_stop_is_not_sent(bench):
    drive = bench.arbiter.execute('goto 12', ROUTE)
    bench.arbiter.execute('stop', PERSON)
    bench.end(drive, Outcome.INTERRUPTED)
    with pytest.raises(Overruled):
        bench.arbiter.execute('goto 14', ROUTE)
    bench.now += LATE
    bench.arbiter.execute('goto 14', ROUTE)
    assert bench.given == ['goto 12', 'stop', 'goto 14']


def test_a_stop_without_a_link_came_to_nothing(bench):
    bench.arbiter.execute('goto 12', ROUTE)
    bench.connected = False
    with pytest.raises(NotConnected):
        bench.arbiter.execute('stop', PERSON)
    bench.connected = True
    bench.arbiter.execute('goto 14', ROUTE)


def test_a_cancellation_is_a_word_as_well(bench):
    drive = bench.arbiter.execute('goto 12', ROUTE)
    bench.arbiter.cancel(drive, PERSON)
    assert bench.cancelled == [drive]
    with pytest.raises(ArclError, match=f'cancellation of {PERSON}'):
        bench.arbiter.execute('goto 14', ROUTE)


def test_a_robot_that_stops_without_an_order_of_ours_obeys_another_client(bench):
    bench.arbiter.on_reply(Stopping())
    with pytest.raises(Overruled):
        bench.arbiter.execute('goto 12', ROUTE)


def test_a_robot_whose_motors_were_enabled_stops_by_itself(bench):
    bench.arbiter.on_reply(Motors(enabled=True))
    bench.arbiter.on_reply(Stopping())
    bench.arbiter.execute('goto 12', ROUTE)


def test_motors_that_are_switched_off_do_not_make_a_robot_stop_by_itself(bench):
    bench.arbiter.on_reply(Motors(enabled=False))
    bench.arbiter.on_reply(Stopping())
    with pytest.raises(Overruled):
        bench.arbiter.execute('goto 12', ROUTE)


def test_a_drive_that_is_not_allowed_replaces_none_of_its_giver(bench):
    bench.guard.list_goals(frozenset({'12', '14'}))
    drive = bench.arbiter.execute('goto 12', ROUTE)
    with pytest.raises(InvalidCommand):
        bench.arbiter.execute('goto nowhere', ROUTE)
    bench.end(drive, Outcome.INTERRUPTED)
    with pytest.raises(Overruled):
        bench.arbiter.execute('goto 14', ROUTE)


def test_who_gave_only_what_is_not_allowed_has_not_driven_and_his_stop_is_not_passed(bench):
    bench.guard.list_goals(frozenset({'12'}))
    with pytest.raises(InvalidCommand):
        bench.arbiter.execute('goto nowhere', PERSON)
    bench.arbiter.execute('stop', PERSON)
    with pytest.raises(Overruled):
        bench.arbiter.execute('goto 12', ROUTE)


@pytest.mark.parametrize('word', ['stop', 'cancellation'])
def test_while_a_command_is_being_given_others_wait(bench, word):
    """Else a drive that was taken first could come to the robot after the word."""
    drive = bench.arbiter.execute('goto 12', ROUTE)
    came = threading.Event()

    def speak() -> None:
        if word == 'stop':
            bench.arbiter.execute('stop', PERSON)
        else:
            bench.arbiter.cancel(drive, PERSON)
        came.set()
    person = threading.Thread(target=speak)

    def let_the_person_speak() -> None:
        bench.while_giving = lambda: None
        person.start()
        assert not came.wait(0.2)
    bench.while_giving = let_the_person_speak
    bench.arbiter.execute('goto 14', ROUTE)
    assert came.wait(10.0)
    person.join(10.0)
