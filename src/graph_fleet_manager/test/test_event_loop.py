"""The order in which the fleet manager hears what happens."""
from __future__ import annotations

import threading

import pytest
from fleet_builders import AGV, corridor
from supervised_fleet import SupervisedFleet

from graph_fleet_manager.nodes.event_loop import TICK, EventLoop
from graph_fleet_manager.supervision.actions import TellStatus
from graph_fleet_manager.supervision.missions import MissionState, Request


class Clock:
    """Stands still unless it is told otherwise."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def loop(clock):
    loop = EventLoop(clock)
    loop.take()(None, clock.now)  # the first look at the clock
    return loop


def noted(notes, word):
    """An event that writes itself down."""
    def event(supervisor, now):
        notes.append(word)
        return ()
    return event


def test_a_stop_is_heard_before_all_reports_that_wait(loop):
    notes = []
    for number in range(3):
        loop.put(noted(notes, number))
    loop.put_urgent(noted(notes, 'stop'))
    loop.put_urgent(noted(notes, 'resume'))
    for _ in range(5):
        loop.take()(None, 0.0)
    assert notes == ['stop', 'resume', 0, 1, 2]


def test_the_clock_is_looked_at_in_time_however_many_reports_come(loop, clock):
    notes = []
    for number in range(100):
        loop.put(noted(notes, number))
        clock.now += TICK / 4
        loop.take()(None, clock.now)
    assert 70 < len(notes) < 90, 'every fifth time or so the clock is looked at instead'


def test_a_stop_finds_room_where_too_many_reports_wait(loop, monkeypatch):
    monkeypatch.setattr(loop, '_room', threading.Semaphore(2))
    for number in range(2):
        loop.put(noted([], number))
    late = threading.Thread(target=loop.put, args=(noted([], 'one too many'),), daemon=True)
    late.start()
    stops = []
    loop.put_urgent(noted(stops, 'stop'))
    loop.take()(None, 0.0)
    assert stops == ['stop'] and late.is_alive(), 'the room is for what is not urgent'
    loop.take()
    late.join(10.0)
    assert not late.is_alive()


def test_a_request_is_not_kept_where_there_is_an_answer_to_it_before(loop):
    loop.put_order(lambda supervisor, now: pytest.fail('it is kept'), lambda: ('refused',))
    assert loop.take()(None, 0.0) == ('refused',)
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    assert loop.begin(fleet.supervisor, 0.0) == []


def test_a_request_before_there_is_a_graph_is_answered_once_there_is_one(loop):
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    loop.put_order(lambda supervisor, now: supervisor.request(Request(1, (3,)), now))
    loop.put_report(lambda supervisor, now: pytest.fail('an old report means nothing'))
    assert [*loop.take()(None, 0.0), *loop.take()(None, 0.0)] == []
    told = [action.status.state for action in loop.begin(fleet.supervisor, 0.0)
            if isinstance(action, TellStatus)]
    assert told == [MissionState.PENDING]
    assert loop.begin(fleet.supervisor, 0.0) == [], 'it is heard once'
