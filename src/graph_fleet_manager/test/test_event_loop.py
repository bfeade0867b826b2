"""The order in which the fleet manager processes events."""
from __future__ import annotations

import threading
from random import Random

import pytest
from fleet_builders import AGV, corridor

from fleet_core.interlocking.reports import Report
from fleet_core.supervision.actions import Note, PublishStatus
from fleet_core.supervision.missions import CommandKind, MissionState, Request
from fleet_core.supervision.outages import Outage
from graph_fleet_manager.nodes import event_loop
from graph_fleet_manager.nodes.event_loop import BATCH, SupervisorEvents
from graph_fleet_manager.nodes.turns import LATEST, TICK, TurnKind
from world.supervised_fleet import SupervisedFleet


class Clock:
    """A clock that the test sets."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def loop(clock):
    loop = SupervisorEvents(clock)
    loop.next_event()(None, clock.now)  # the first tick
    return loop


def noted(notes, word):
    """Returns an event that adds its own name to `notes`."""
    def event(supervisor, now):
        notes.append(word)
        return ()
    return event


def reported(notes, word):
    """Returns a report that adds its own name to `notes`."""
    return lambda supervisor, now, arrived: noted(notes, word)(supervisor, now)


def test_stops_come_before_commands_and_commands_before_reports(loop):
    notes = []
    for number in range(3):
        loop.put_report(reported(notes, number))
    loop.put(noted(notes, 'command'))
    loop.put_urgent(noted(notes, 'stop'))
    loop.put_urgent(noted(notes, 'resume'))
    for _ in range(6):
        loop.next_event()(object(), 0.0)
    assert notes == ['stop', 'resume', 'command', 0, 1, 2]


def test_only_the_newest_report_of_each_robot_waits_and_keeps_the_turn_of_the_oldest(loop, clock):
    notes = []
    for number in range(5):
        clock.now += TICK / 10
        for robot in ('a', 'b'):
            loop.put_report(lambda _, now, arrived, robot=robot, number=number: notes.append(
                (robot, number, arrived)) or (), robot)
        loop.put_report(reported(notes, number))
    for _ in range(7):
        loop.next_event()(object(), clock.now)
    assert notes == [('a', 4, clock.now), ('b', 4, clock.now), 0, 1, 2, 3, 4]


def test_the_clock_is_looked_at_in_time_however_many_reports_come(loop, clock, fleet):
    notes = []
    for number in range(100):
        loop.put_report(reported(notes, number))
        clock.now += TICK / 4
        loop.next_event()(fleet.supervisor, clock.now)
    assert 80 < len(notes) < 95, 'ticks must be taken although more events come than can be taken'


def test_reports_and_commands_that_arrived_before_a_tick_was_due_go_before_it(loop, clock):
    notes = []
    for number in range(3):
        clock.now += TICK
        loop.put_report(reported(notes, number))
    loop.put(noted(notes, 'command'))
    for _ in range(4):
        loop.next_event()(object(), clock.now)
    assert notes == ['command', 0, 1, 2]
    loop.next_event()
    clock.now += TICK / 2
    loop.put_report(reported(notes, 'later'))
    loop.next_event()(object(), clock.now)
    assert notes[4:] == ['later'], 'a tick was taken between them'


def test_a_tick_that_many_reports_keep_away_comes_in_time_and_knows_which_reports_still_wait(
        loop, clock, fleet):
    heard = []
    fleet.supervisor.tick = lambda now, until: heard.append((now, until)) or ()
    arrived = clock.now
    for number in range(200):
        loop.put_report(lambda *_: (), f'{number}')
    due = clock.now + TICK
    while not heard:
        clock.now += TICK / 5
        loop.next_event()(fleet.supervisor, clock.now)
    (ticked, until), = heard
    assert ticked <= due + LATEST + TICK / 5
    assert until == arrived, 'a robot may have reported meanwhile'


class WatchedLoop:
    """An event loop in which every event takes some time, with a record of the events taken."""

    def __init__(self, seed):
        self.random, self.clock = Random(seed), Clock()
        self.loop = SupervisorEvents(self.clock, lambda: 'requests are refused')
        self.arrived = {'stop': [], 'command': [], 'report': [], 'request': []}
        self.taken = {'stop': [], 'command': [], 'report': [], 'request': [], 'tick': []}
        self.heard = []
        self.slowness = self.random.choice((0.1, 1.0, 5.0)) * TICK

    def arrives(self, kind):
        """Queues an event or a request that arrives now."""
        number = len(self.arrived[kind])
        self.arrived[kind].append(self.clock.now)

        def event(*_):
            self.taken[kind].append(number)
            return ()
        if kind == 'request':
            self.loop.put_request(Request(number, (1,)))
        elif kind == 'report':
            self.loop.put_report(event)
        else:
            (self.loop.put_urgent if kind == 'stop' else self.loop.put)(event)

    def waiting(self, kind):
        """Returns the times of arrival of all events of a kind that were not taken yet."""
        return self.arrived[kind][len(self.taken[kind]):]

    def tick(self, now, heard):
        """Records a tick of the supervisor."""
        self.taken['tick'].append(now)
        self.heard.append(heard)
        return ()

    def requests(self, requests, now):
        """Records requests that the supervisor gets."""
        self.taken['request'] += [request.id for request in requests]
        return ()

    def next_event(self):
        """Runs one turn of the thread, in which more events may arrive. Returns the event's kind
        and duration."""
        before, begun = {kind: len(taken) for kind, taken in self.taken.items()}, self.clock.now
        event = self.loop.next_event()
        took = self.random.random() * self.slowness
        arriving = self.random.choice((0, 0, 1, 1, 2))
        for _ in range(arriving):
            self.clock.now += took / arriving
            self.arrives(self.random.choice(('stop', 'command', 'report', 'report', 'request')))
        event(self, begun)
        return next(kind for kind in before if len(self.taken[kind]) > before[kind]), took


@pytest.mark.parametrize('seed', range(50))
def test_whatever_comes_and_however_long_it_takes_the_order_is_kept(seed):
    watched = WatchedLoop(seed)
    watched.loop.begin()
    due = free = watched.clock.now
    since_tick, longest = [], 0.0
    for _ in range(400):
        if not any(watched.waiting(kind) for kind in watched.arrived):
            watched.clock.now = max(watched.clock.now, due)  # nothing happens until the next tick
        waiting = {kind: watched.waiting(kind) for kind in watched.arrived}
        now = watched.clock.now
        kind, took = watched.next_event()
        longest = max(longest, took)
        is_late = now >= max(due, free) + LATEST
        if waiting['stop']:
            assert kind == 'stop', 'something was taken before a stop'
        if kind == 'report':
            assert not waiting['command'] and not is_late
        if kind in ('tick', 'request') and not is_late:
            assert not waiting['command']
            assert not [at for at in waiting['report'] if at <= min(due, now)], (
                'it arrived before the tick was due')
        if kind == 'request' and len(waiting['request']) <= BATCH:
            due = min(due, now)
        if kind != 'tick':
            stops = kind == 'stop' or 'stop' in since_tick
            assert stops or now <= max(due, free) + LATEST + 2.0 * longest, 'the tick comes late'
            since_tick.append(kind)
            continue
        assert now >= due
        assert 'request' in since_tick or not waiting['request'], 'requests must get a turn'
        assert all(at >= watched.heard[-1] for at in waiting['report'])
        assert watched.heard == sorted(watched.heard)
        due, free, since_tick = now + TICK, watched.clock.now, []
        if watched.waiting('command') or watched.waiting('report'):
            assert watched.loop._turns.next(watched.loop._waiting(), free) not in (
                None, TurnKind.TICK), 'one tick keeps all others away'
    for kind in watched.arrived:
        numbers = watched.taken[kind]
        assert numbers == list(range(len(numbers))), f'each {kind} must be taken once, in order'
    assert len(watched.taken['tick']) > 10, 'a tick must be taken'


@pytest.fixture
def fleet():
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    fleet.run(3.0)
    return fleet


def test_after_a_stall_no_robot_is_silent_that_reported_meanwhile(fleet):
    """A command that arrived during the stall makes no difference."""
    loop = SupervisorEvents(lambda: fleet.now)
    fleet.request(1, 3)
    for late in range(28):
        fleet.now += 0.25
        report = fleet.agvs['a'].report(fleet.now)
        loop.put_report(lambda supervisor, now, arrived, report=report: supervisor.report(
            'a', Report(report), now, arrived), 'a')
        if late == 3:
            loop.put_order(lambda supervisor, now: supervisor.command(1, CommandKind.PAUSE, now))
    for _ in range(30):
        loop.next_event()(fleet.supervisor, fleet.now)
        assert fleet.supervisor.robots['a'].outage is None
    assert fleet.supervisor.book.find(1).state is MissionState.PAUSED


def test_after_the_process_stood_still_no_robot_is_silent_that_reported_meanwhile(
        fleet, monkeypatch):
    """The robot's reports waited in a socket, and no callback could note when they came."""
    loop = SupervisorEvents(lambda: fleet.now)
    loop.next_event()(fleet.supervisor, fleet.now)
    fleet.now += 7.0

    def read(seconds):
        report = fleet.agvs['a'].report(fleet.now)
        fleet.now += seconds / 2
        loop.put_report(lambda supervisor, now, arrived: supervisor.report(
            'a', Report(report), now, arrived))
        return True
    monkeypatch.setattr(loop._changed, 'wait', read)
    for _ in range(20):
        loop.next_event()(fleet.supervisor, fleet.now)
        assert fleet.supervisor.robots['a'].outage is None


def test_a_robot_that_does_not_report_is_silent_also_after_a_stall(fleet):
    loop = SupervisorEvents(lambda: fleet.now)
    fleet.now += 10.0
    loop.next_event()(fleet.supervisor, fleet.now)
    assert fleet.supervisor.robots['a'].outage is Outage.SILENT


def test_a_tick_is_due_at_once_when_the_last_request_is_taken(fleet):
    loop = SupervisorEvents(lambda: fleet.now)
    loop.next_event()(fleet.supervisor, fleet.now)
    loop.begin()
    loop.put_request(Request(1, (3,)))
    assert told_by(loop.next_event()(fleet.supervisor, fleet.now)) == [(1, MissionState.PENDING)]
    fleet.now += TICK / 10
    assert told_by(loop.next_event()(fleet.supervisor, fleet.now)) == [(1, MissionState.ACTIVE)]


def test_a_stop_finds_room_where_too_many_reports_wait(loop, monkeypatch):
    monkeypatch.setattr(loop, '_room', threading.Semaphore(2))
    for number in range(2):
        loop.put(noted([], number))
    late = threading.Thread(target=loop.put, args=(noted([], 'one too many'),), daemon=True)
    late.start()
    stops = []
    loop.put_urgent(noted(stops, 'stop'))
    loop.next_event()(None, 0.0)
    assert stops == ['stop'] and late.is_alive(), 'the limit must not apply to urgent events'
    loop.next_event()
    late.join(10.0)
    assert not late.is_alive()


def told_by(actions):
    """Returns the id and state in each published status."""
    return [(action.status.request_id, action.status.state) for action in actions
            if isinstance(action, PublishStatus)]


def test_a_request_is_not_kept_where_it_cannot_be(clock):
    loop = SupervisorEvents(clock, lambda: 'the disk is full')
    loop.put_request(Request(1, (3,)))
    refusal, = loop.next_event()(None, 0.0)
    assert (refusal.status.state, refusal.status.reason) == (MissionState.REFUSED,
                                                             'the disk is full')


def take_all(loop, fleet, turns):
    """Takes the given number of turns. Returns their actions."""
    return [action for _ in range(turns)
            for action in loop.next_event()(fleet.supervisor, fleet.now)]


def test_requests_and_commands_before_there_is_a_graph_are_carried_out_once_there_is_one(
        loop, fleet):
    loop.put_request(Request(1, (3,)))
    loop.put_request(Request(2, (2,)))
    loop.put_command(2, CommandKind.PAUSE)
    loop.put_command(2, CommandKind.CANCEL)
    loop.put_report(lambda supervisor, now, arrived: pytest.fail('an old report must not count'))
    for _ in range(3):
        assert loop.next_event()(None, 0.0) == ()
    loop.begin()
    assert told_by(take_all(loop, fleet, 3)) == [
        (2, MissionState.PENDING), (2, MissionState.PAUSED), (2, MissionState.CANCELLED),
        (1, MissionState.PENDING)]
    assert fleet.supervisor.book.find(2).state is MissionState.CANCELLED


def test_as_many_requests_as_may_be_open_are_kept_and_what_comes_beyond_is_told(
        loop, fleet, monkeypatch):
    monkeypatch.setattr(event_loop, 'MOST_OPEN', 50)
    for id in range(51):
        loop.put_request(Request(id + 1, (3,)))
    refusal, = loop.next_event()(None, 0.0)
    assert refusal.status.request_id == 51
    assert '5000 already wait' in refusal.status.reason
    for _ in range(50):
        loop.put_command(1, CommandKind.PAUSE)
        assert loop.next_event()(None, 0.0) == ()
    loop.put_command(1, CommandKind.PAUSE)
    note, = loop.next_event()(None, 0.0)
    assert isinstance(note, Note) and 'PAUSE for mission 1 is ignored' in note.text
    loop.begin()
    take_all(loop, fleet, 51)
    assert [fleet.state(id + 1) for id in range(50)] == [
        MissionState.PAUSED, *[MissionState.PENDING] * 49]


def test_a_command_overtakes_all_requests_but_those_that_it_is_about(loop, fleet):
    fleet.request(1, 3)
    loop.begin()
    for id in range(2, 500):
        loop.put_request(Request(id, (3,)))
    loop.put_command(1, CommandKind.CANCEL)
    loop.put_command(400, CommandKind.CANCEL)
    assert told_by(take_all(loop, fleet, 1))[0] == (1, MissionState.CANCELLED)
    assert told_by(take_all(loop, fleet, 1)) == [
        (400, MissionState.PENDING), (400, MissionState.CANCELLED)]


def test_requests_that_come_together_share_a_commit(loop, fleet):
    loop.begin()
    for id in range(BATCH):
        loop.put_request(Request(id + 1, (3,)))
    before = fleet.disk.journal.commits
    told = told_by(take_all(loop, fleet, 1))
    assert told == [(id + 1, MissionState.PENDING) for id in range(BATCH)]
    assert fleet.disk.journal.commits == before + 1


def test_a_tick_that_is_wanted_earlier_comes_earlier_but_after_what_arrived_before(loop, clock):
    notes = []
    loop.hurry(clock.now + TICK / 4)
    loop.hurry(clock.now + TICK / 2)
    loop.hurry(None)
    loop.put_report(reported(notes, 'before'))
    clock.now += TICK / 4
    loop.next_event()(object(), clock.now)
    assert notes == ['before']
    clock.now += TICK / 100
    loop.put_report(reported(notes, 'after'))
    loop.next_event()
    assert notes == ['before'], 'the tick was due'
    loop.next_event()(object(), clock.now)
    assert notes == ['before', 'after']
