"""The order in which the fleet manager hears what happens."""
from __future__ import annotations

import threading
from random import Random

import pytest
from fleet_builders import AGV, corridor
from supervised_fleet import SupervisedFleet

from graph_fleet_manager.nodes.event_loop import TICK, EventLoop
from graph_fleet_manager.supervision.actions import TellStatus
from graph_fleet_manager.supervision.missions import Command, MissionState, Request
from graph_fleet_manager.supervision.outages import Outage


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
    assert 80 < len(notes) < 95, 'the clock is looked at, although more come than can be taken'


def test_reports_and_commands_that_arrived_before_a_tick_was_due_go_before_it(loop, clock):
    notes = []
    for number in range(3):
        clock.now += 1.0
        loop.put(noted(notes, number))
    for _ in range(3):
        loop.take()(None, clock.now)
    assert notes == [0, 1, 2]
    loop.take()
    clock.now += TICK / 2
    loop.put(noted(notes, 'later'))
    loop.take()(None, clock.now)
    assert notes[3:] == ['later'], 'a tick was taken between them'


class WatchedLoop:
    """An event loop in which everything takes some time, and what its thread took."""

    def __init__(self, seed):
        self.random, self.clock = Random(seed), Clock()
        self.loop = EventLoop(self.clock)
        self.arrived = {'stop': [], 'event': [], 'request': []}
        self.taken = []  # what, its number, when
        self.slowness = self.random.choice((0.1, 1.0, 5.0)) * TICK

    def arrives(self, kind):
        """Something comes in."""
        number = len(self.arrived[kind])
        self.arrived[kind].append(self.clock.now)

        def event(supervisor, now):
            self.taken.append((kind, number, now))
            return ()
        if kind == 'request':
            self.loop.put_request(lambda supervisor, now: (), lambda: event(None, self.clock.now))
        else:
            (self.loop.put_urgent if kind == 'stop' else self.loop.put)(event)

    def waiting(self, kind):
        """When everything arrived that was not taken yet."""
        return self.arrived[kind][sum(one == kind for one, _, _ in self.taken):]

    def take(self):
        """One turn of the thread, during which more may arrive."""
        before = len(self.taken)
        begun = self.clock.now
        self.loop.take()(None, begun)
        if len(self.taken) == before:
            self.taken.append(('tick', 0, begun))
        for _ in range(self.random.choice((0, 0, 1, 1, 2))):
            self.clock.now += self.random.random() * self.slowness
            self.arrives(self.random.choice(('stop', 'event', 'event', 'event', 'request')))


@pytest.mark.parametrize('seed', range(50))
def test_whatever_comes_and_however_long_it_takes_the_order_is_kept(seed):
    watched = WatchedLoop(seed)
    due, requests = watched.clock.now, 0
    for turn in range(400):
        if not any(watched.waiting(kind) for kind in watched.arrived):
            watched.clock.now = max(watched.clock.now, due)  # nothing happens until the next tick
        waiting = {kind: watched.waiting(kind) for kind in watched.arrived}
        watched.take()
        kind, _, now = watched.taken[turn]
        if waiting['stop']:
            assert kind == 'stop', 'nothing goes before a stop'
        if kind in ('tick', 'request'):
            assert not [at for at in waiting['event'] if at <= min(due, now)], 'it arrived before'
        if kind == 'request':
            requests += 1
            due = min(due, now) if len(waiting['request']) == 1 else due
        if kind == 'tick':
            assert now >= due
            assert requests or not waiting['request'], 'requests have a turn'
            due, requests = now + TICK, 0
    for kind in watched.arrived:
        numbers = [number for what, number, _ in watched.taken if what == kind]
        assert numbers == list(range(len(numbers))), f'each {kind} is taken once, in order'
    assert sum(kind == 'tick' for kind, _, _ in watched.taken) > 10, 'the clock is looked at'


@pytest.fixture
def fleet():
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    fleet.run(3.0)
    return fleet


def test_after_a_stall_no_robot_is_silent_that_reported_meanwhile(fleet):
    """A command that came during the stall changes nothing about that."""
    loop = EventLoop(lambda: fleet.now)
    fleet.request(1, 3)
    for late in range(28):
        fleet.now += 0.25
        report = fleet.agvs['a'].report(fleet.now)
        loop.put_report(lambda supervisor, now, arrived, report=report: supervisor.report(
            'a', report, now, arrived))
        if late == 3:
            loop.put_order(lambda supervisor, now: supervisor.command(1, Command.PAUSE, now))
    for _ in range(30):
        loop.take()(fleet.supervisor, fleet.now)
        assert fleet.supervisor.robots['a'].outage is None
    assert fleet.supervisor.book.find(1).state is MissionState.PAUSED


def test_a_robot_that_does_not_report_is_silent_also_after_a_stall(fleet):
    loop = EventLoop(lambda: fleet.now)
    fleet.now += 10.0
    loop.take()(fleet.supervisor, fleet.now)
    assert fleet.supervisor.robots['a'].outage is Outage.SILENT


def test_a_tick_is_due_at_once_when_the_last_request_is_taken(loop, clock):
    notes = []
    for number in range(2):
        loop.put_request(lambda supervisor, now: (), lambda number=number: notes.append(number))
    for _ in range(2):
        loop.take()(None, clock.now)
    assert notes == [0, 1]
    loop.put(noted(notes, 'later'))
    clock.now += TICK / 10
    loop.take()(None, clock.now)
    loop.take()(None, clock.now)
    assert notes == [0, 1, 'later'], 'and then the tick'


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
    loop.put_request(lambda supervisor, now: pytest.fail('it is kept'), lambda: ('refused',))
    assert loop.take()(None, 0.0) == ('refused',)
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    assert loop.begin(fleet.supervisor, 0.0) == []


def test_a_request_before_there_is_a_graph_is_answered_once_there_is_one(loop):
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    loop.put_order(lambda supervisor, now: supervisor.request(Request(1, (3,)), now))
    loop.put_report(lambda supervisor, now, arrived: pytest.fail('an old report means nothing'))
    assert [*loop.take()(None, 0.0), *loop.take()(None, 0.0)] == []
    told = [action.status.state for action in loop.begin(fleet.supervisor, 0.0)
            if isinstance(action, TellStatus)]
    assert told == [MissionState.PENDING]
    assert loop.begin(fleet.supervisor, 0.0) == [], 'it is heard once'
