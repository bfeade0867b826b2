"""Jobs, cancellations, lost messages and clients, full disks and restarts, in any order.

The model is the lines that clients got. Each job that was `successfully queued` is done once, or
ends in another state; its lines agree with its mission. Records posted over REST are kept.
"""
from __future__ import annotations

import json
from dataclasses import replace
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple, Type

import pytest
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)
from job_fleet import Disk, FakeFleet, Key, places_of, tell

from omron_jobs.core.client_session import ClientSession, JobServer
from omron_jobs.core.job_book import FleetAct, FleetMessage, JobBook, JobCounters, JobGoal
from omron_jobs.core.job_commands import JobCommands, JobSite
from omron_jobs.core.jobs import JobMission, JobMissionState, QueuedJob, SegmentChange
from omron_jobs.core.posted_records import PostedRecord
from omron_jobs.core.rest_api import RestApi
from omron_jobs.core.rest_records import RestRecords
from omron_jobs.core.rest_words import RestType

State = JobMissionState
FINAL = ('Completed', 'Cancelled', 'Failed')
ENDS = {State.SUCCEEDED: 'Completed', State.CANCELLED: 'Cancelled', State.REFUSED: 'Cancelled',
        State.FAILED: 'Failed'}
PICK = st.integers(0, 30)


class JobsInAnyOrder(RuleBasedStateMachine):
    Book = JobBook

    @initialize()
    def begin(self) -> None:
        self.disk, self.fleet = Disk(), FakeFleet()
        self.now = 0.0
        self.ids = iter(range(1, 10 ** 6))
        self.queued: Dict[str, int] = {}
        """The number of segments of each accepted job, by the id of its first segment."""
        self.cancelled: List[str] = []
        self.posted: Dict[Tuple[RestType, str], Any] = {}
        """The records of REST to which the answer was 201, by type and key."""
        self.start()

    def start(self) -> None:
        self.book = self.Book(self.disk.jobs.values(), self.disk.counters, self.disk,
                              lambda: 1 + int(self.now * 1000), lambda: next(self.ids))
        site = JobSite()
        site.goals = {'x': 1, 'y': 2, 'z': 3}
        self.server = JobServer(JobCommands(self.book, site), b'p')
        self.records = RestRecords(self.book, site, lambda: 1 + int(self.now * 1000),
                                   self.disk.posted)
        self.rest = RestApi(self.book, site, self.records, self.server.announce)
        self.clients: List[ClientSession] = []
        self.told: Dict[ClientSession, Dict[str, str]] = {}
        self.connect()

    def say(self, line: str) -> List[str]:
        """Sends a line of the first client. Returns the replies."""
        self.clients[0].receive(line.encode() + b'\n')
        return [told for told in self.hear(self.clients[0]) if not told.startswith('QueueUpdate')]

    def hear(self, client: ClientSession) -> List[str]:
        lines = client.output.decode().split('\r\n')[:-1]
        client.output.clear()
        for line in lines:
            if line.startswith('QueueUpdate: '):
                segment, status = line.split()[1], line.split()[4]
                assert self.told[client].get(segment) not in FINAL, 'told after its end'
                self.told[client][segment] = status
        return lines

    # -- clients -----------------------------------------------------------------------------------

    @rule()
    def connect(self) -> None:
        client = self.server.connect()
        client.receive(b'p\n')
        client.output.clear()
        self.clients.append(client)
        self.told[client] = {}

    @rule(which=PICK)
    def lose_client(self, which: int) -> None:
        if len(self.clients) > 1:
            self.clients.pop(which % len(self.clients)).close()

    @rule(command=st.sampled_from((
        ('queuePickup x', 1), ('queuePickupDropoff x y 5 6', 2),
        ('queuePickupDropoff y z', 2), ('queuePickup x 3 JOB4', 1),
        ('queueMulti 3 2 x pickup 1 y pickup default y dropoff 2', 3))))
    def queue(self, command: Tuple[str, int]) -> None:
        line, count = command
        told = self.say(line)
        if 'successfully queued' in told[0]:
            words = told[0].split()
            first = words[words.index('ids' if 'ids' in words else 'id') + 1]
            assert first not in self.queued, 'an id is used twice'
            self.queued[first] = count
        else:
            assert self.disk.is_full or 'is the id of an active job' in told[1]

    @rule(which=PICK)
    def cancel(self, which: int) -> None:
        if self.queued:
            first = sorted(self.queued)[which % len(self.queued)]
            if self.say(f'queueCancel id {first}')[0].startswith('queuecancel cancelling'):
                self.cancelled.append(first)

    @rule(which=PICK, priority=st.integers(0, 40))
    def modify(self, which: int, priority: int) -> None:
        if self.queued:
            first = sorted(self.queued)[which % len(self.queued)]
            self.say(f'queueModify {first} priority {priority}')

    @rule()
    def show_drives(self) -> None:
        self.server.announce(self.book.hear_drives(self.fleet.drives()))
        self.after_news()

    @rule(which=PICK, later=st.integers(0, 2), goal=st.sampled_from('xyz'))
    def change_goal(self, which: int, later: int, goal: str) -> None:
        segments = [one for job in self.book.jobs for one in job.segments]
        if segments:
            self.say(f'queueModify {segments[(which + later) % len(segments)].id} goal {goal}')

    @rule(refuses=st.booleans())
    def fleet_refuses_changes(self, refuses: bool) -> None:
        self.fleet.refuses_changes = refuses

    # -- the fleet ---------------------------------------------------------------------------------

    @rule(lost=st.lists(st.booleans(), max_size=6), twice=st.booleans())
    def exchange(self, lost: List[bool], twice: bool) -> None:
        """The messages due are sent. Some messages and answers are lost; others arrive twice."""
        losses = iter(lost)
        for message in self.book.due(self.now) + self.book.silent(self.now):
            for _ in range(1 + twice):
                if not next(losses, False):
                    for key, shown in list(self.fleet.handle(message)):
                        if not next(losses, False):
                            self.server.announce(tell(self.book, key, shown, self.now))
        self.after_news()

    def after_news(self) -> None:
        try:
            self.book.store_news()
        except OSError:
            assert self.disk.is_full
        for client in self.clients:
            self.hear(client)

    @rule(which=PICK, robot=st.sampled_from(('r1', 'r2')), is_heard=st.booleans(),
          event=st.sampled_from(('begin', 'begin', 'reach', 'reach', 'reach', 'fail', 'pause',
                                 'drop', 'cancel')))
    def event_of_a_mission(self, which: int, robot: str, is_heard: bool, event: str) -> None:
        open_ones = [key for key, one in self.fleet.missions.items() if one.shown.state.is_open]
        if not open_ones:
            return
        key = open_ones[which % len(open_ones)]
        shown = self.fleet.missions[key].shown
        if event == 'begin':
            self.fleet.set(key, State.ACTIVE, shown.robot or robot)
        elif event == 'reach' and shown.state is State.ACTIVE:
            self.fleet.reach(key)
        elif event == 'fail':
            self.fleet.set(key, State.FAILED)
        elif event == 'pause':
            self.fleet.set(key, State.PAUSED)
        elif event == 'drop' and not shown.reached:
            self.fleet.set(key, State.PENDING, '')
        elif event == 'cancel':
            self.fleet.set(key, State.CANCELLED)
        if is_heard:
            self.show(key)

    @rule(which=PICK, state=st.sampled_from((State.FAILED, State.CANCELLED)))
    def end_unheard(self, which: int, state: State) -> None:
        """The job server knows a mission. The mission ends, and its last status is lost. Random
        rules seldom cause this.
        """
        self.exchange([], False)
        open_ones = [key for key, one in self.fleet.missions.items() if one.shown.state.is_open]
        for key in open_ones[which % max(1, len(open_ones)):][:1]:
            self.fleet.set(key, state)

    def show(self, key: Key) -> None:
        self.server.announce(tell(self.book, key, self.fleet.missions[key].shown, self.now))
        self.after_news()

    # -- the computer ------------------------------------------------------------------------------

    @rule(seconds=st.sampled_from((0.1, 3.0, 11.0)))
    def wait(self, seconds: float) -> None:
        self.now += seconds

    @rule(is_full=st.booleans())
    def disk_changes(self, is_full: bool) -> None:
        self.disk.is_full = is_full

    @rule()
    def restart(self) -> None:
        self.start()

    # -- what holds --------------------------------------------------------------------------------

    @invariant()
    def every_mission_is_one_job_and_no_stop_is_driven_twice(self) -> None:
        jobs = {(job.mission, job.queued): job for job in self.book.jobs}
        assert set(self.fleet.missions) <= set(jobs)
        firsts = [job.segments[0].id for job in self.book.jobs]
        assert len(firsts) == len(set(firsts)) and set(firsts) == set(self.queued)
        assert len(self.fleet.driven) == len(set(self.fleet.driven))

    @invariant()
    def nothing_is_completed_that_was_not_driven(self) -> None:
        for job in self.book.jobs:
            mission = self.fleet.missions.get((job.mission, job.queued))
            done = [one.told.status.value == 'Completed' for one in job.segments]
            assert mission is None or [
                one.vertex for one, is_done in zip(job.segments, done) if is_done] == [
                place for place, is_done in zip(mission.shown.places, done) if is_done]
            assert sum(done) <= (mission.shown.reached if mission else 0)
            assert done == sorted(done, reverse=True)

    def teardown(self) -> None:
        """From now on nothing is lost: each job ends, in the state of its mission."""
        if not hasattr(self, 'disk'):
            return
        self.disk.is_full = self.fleet.refuses_changes = False
        cancelled = {key for key, mission in self.fleet.missions.items()
                     if mission.shown.state.is_open and any(
                         (job.mission, job.queued) == key and job.segments[0].id in self.cancelled
                         for job in self.book.jobs)}
        for k in range(15):
            self.now += 11.0
            self.exchange([], False)
            for key, mission in list(self.fleet.missions.items()):
                if mission.shown.state.is_open and k > 2:
                    assert all((job.segments[0].priority, places_of(job)) == (
                        mission.shown.priority, mission.shown.places) for job in self.book.jobs
                        if (job.mission, job.queued) == key and job.cancel is None)
                    self.fleet.set(key, State.ACTIVE, mission.shown.robot or 'r1')
                    self.fleet.reach(key)
                    self.show(key)
        assert {job.segments[0].id for job in self.book.jobs} == set(self.queued)
        for job in self.book.jobs:
            shown = self.fleet.missions[job.mission, job.queued].shown
            assert not job.is_open
            assert [one.told.status.value for one in job.segments] == [
                'Completed' if k < shown.reached else ENDS[shown.state]
                for k in range(len(job.segments))]
        assert {self.fleet.missions[key].shown.state for key in cancelled} <= {State.CANCELLED}
        self.check_what_clients_heard()

    def check_what_clients_heard(self) -> None:
        shown = {one.id: one.told.status.value for job in self.book.jobs for one in job.segments}
        for client in self.clients:
            for segment, status in self.told[client].items():
                assert status == shown[segment]


class JobsOfBothInterfaces(JobsInAnyOrder):
    """Here cancellations and modifications also come over REST. The machine without REST is
    separate because it finds nearly all planted faults sooner."""

    @rule(which=PICK, key=st.sampled_from(('', 'a', 'b')), wish=st.sampled_from((
        ('JobCancel', {'cancelReason': 'why'}), ('JobSegmentModify', {'priority': 4}),
        ('JobSegmentModify', {'goal': 'y'}))))
    def post(self, which: int, key: str, wish: Tuple[str, Dict[str, Any]]) -> None:
        if not self.queued:
            return
        first = sorted(self.queued)[which % len(self.queued)]
        kind, named = wish[0], {'segmentId': first}
        if kind == 'JobCancel':
            named = {'cancelType': 'SegmentId', 'cancelValue': first}
        answer = self.rest.answer('POST', f'/{kind}', {}, json.dumps(
            {'namekey': key, **named, **wish[1]}).encode())
        if answer.status == 201:
            posted = RestType(kind), answer.body['namekey']
            assert posted not in self.posted, 'a key counts twice'
            self.posted[posted] = answer.body
            if kind == 'JobCancel':
                self.cancelled.append(first)
        self.after_news()

    @invariant()
    def what_was_posted_is_shown_as_it_was_answered(self) -> None:
        for posted, record in self.posted.items():
            assert self.records.by_key(*posted) == record


TestJobsInAnyOrder = JobsOfBothInterfaces.TestCase


# -- planted faults --------------------------------------------------------------------------------


class StoresLate(JobBook):
    """A faulty book: it accepts a job before the job is on the disk."""

    def queue(self, goals: Sequence[JobGoal], *others: Any, **named: Any) -> QueuedJob:
        disk, self._store = self._store, Disk()
        try:
            return super().queue(goals, *others, **named)
        finally:
            self._store = disk


class StampsAnew(JobBook):
    """A faulty book: it gives each repeat of a request another stamp."""

    def due(self, now: float) -> List[FleetMessage]:
        return [message._replace(job=replace(message.job, queued=message.job.queued + 1 + k))
                for k, message in enumerate(super().due(now))]


class CancelsOnce(JobBook):
    """A faulty book: it does not repeat a cancellation that was lost."""

    def due(self, now: float) -> List[FleetMessage]:
        sent = self.__dict__.setdefault('cancelled', set())
        found = [message for message in super().due(now)
                 if message.act is not FleetAct.CANCEL or message.job.mission not in sent]
        sent.update(message.job.mission for message in found if message.act is FleetAct.CANCEL)
        return found


class ChangesOnce(JobBook):
    """A faulty book: it does not repeat a change that was lost."""

    def due(self, now: float) -> List[FleetMessage]:
        sent = self.__dict__.setdefault('changed', set())
        found = [message for message in super().due(now) if message.act is not FleetAct.CHANGE or (
            message.job.mission, message.job.segments) not in sent]
        sent.update((message.job.mission, message.job.segments) for message in found)
        return found


class KeepsTheNewGoal(JobBook):
    """A faulty book: it keeps the new goal although the mission ended at the old goal."""

    def hear(self, mission: int, stamp: int, news: JobMission, now: float) -> List[SegmentChange]:
        return super().hear(mission, stamp, news._replace(places=()), now)


class ForgetsItsCounter(JobBook):
    """A faulty book: its counters begin at their first values after each start."""

    def __init__(self, jobs: Iterable[QueuedJob], counters: JobCounters, *others: Any) -> None:
        super().__init__(jobs, JobCounters(), *others)


class StoresNoRecords(JobBook):
    """A faulty book: it stores the jobs that a REST record changes, but not the record."""

    def _keep(self, jobs: Sequence[QueuedJob], posted: Optional[PostedRecord]) -> None:
        super()._keep(jobs, None)


class AsksNobody(JobBook):
    """A faulty book: it asks no questions about silent missions."""

    def silent(self, now: float) -> List[FleetMessage]:
        return []


@pytest.mark.parametrize('book', [StoresLate, StampsAnew, CancelsOnce, ChangesOnce,
                                  KeepsTheNewGoal, ForgetsItsCounter, StoresNoRecords,
                                  AsksNobody])
def test_a_planted_fault_is_found(book: Type[JobBook]) -> None:
    machine = JobsOfBothInterfaces if book is StoresNoRecords else JobsInAnyOrder
    faulty = seed(0)(type('Faulty', (machine,), {'Book': book}))
    with pytest.raises((AssertionError, KeyError)):
        run_state_machine_as_test(faulty, settings=settings(
            max_examples=2000, deadline=None, derandomize=True, database=None,
            phases=[Phase.generate], suppress_health_check=list(HealthCheck)))
