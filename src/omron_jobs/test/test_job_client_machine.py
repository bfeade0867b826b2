"""Jobs, cancellations, lost links and restarts of both sides in any order, against a simulated
Fleet Manager in memory: no job is done twice, none is lost, and each ends in its true state.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, List, Optional, Tuple, Type

import pytest
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    rule,
    run_state_machine_as_test,
)
from simulated_manager import Robot

from omron_jobs.client.fleet_manager_lines import AnswerEnd, WrongJob, read_line
from omron_jobs.client.handed_jobs import (
    HandedEvent,
    HandedJob,
    HandedState,
    HandedStop,
    HandedStopKind,
    Modification,
)
from omron_jobs.client.job_client import ASKED_EVERY, RESENT_WITHIN, JobClient
from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.fleet_manager import SimFleetManager
from omron_ld90_sim.interface.job_queue import QueueSegment
from omron_ld90_sim.interface.session import SimSession

P, D = HandedStopKind.PICKUP, HandedStopKind.DROPOFF
JOBS: Tuple[Tuple[HandedStop, ...], ...] = (
    (HandedStop('x', P),), (HandedStop('x', P, 5), HandedStop('y z', D)),
    (HandedStop('x', P), HandedStop('y z', D, 3), HandedStop('x', D)),
    (HandedStop('x', P), HandedStop('nowhere', D)), (HandedStop('y z', P), HandedStop('x', D)))
GOALS = ('x', 'y z', 'nowhere')
STATES = {'Completed': HandedState.COMPLETED, 'Cancelled': HandedState.CANCELLED}
PICK = st.integers(0, 30)


class HandedJobsInAnyOrder(RuleBasedStateMachine):
    Client: Type[JobClient] = JobClient

    @initialize()
    def begin(self) -> None:
        self.clock = SimClock()
        self.robots = [Robot('r1'), Robot('r2')]
        self.manager = SimFleetManager(self.clock, self.robots, lambda: ['x', 'y z'], 'p')
        self.carry_out, self.manager.queue.modify = self.manager.queue.modify, self.modified
        self.disk: Dict[str, HandedJob] = {}
        self.is_full = False
        self.count, self.slept = 0, 0.0
        self.wanted: Dict[str, int] = {}    # the ids of the jobs that were promised
        self.to_server, self.to_client = bytearray(), bytearray()
        self.restart_client()

    def store(self, jobs: List[HandedJob]) -> None:
        if self.is_full:
            raise OSError(28, 'No space left on device')
        self.disk = {job.id: job for job in jobs}

    def new_id(self) -> str:
        self.count += 1
        return f'ROS{self.count}'

    @rule()
    def restart_client(self) -> None:
        self.client = self.Client(self.disk.values(), self.store,
                                  lambda: int(self.now * 1000), self.new_id)
        self.connect()

    @rule()
    def connect(self) -> None:
        """The old link is lost with the bytes on their way; the client logs in over a new link."""
        for old in list(self.manager.sessions):
            old.close(abort=True)
        self.client.hear_loss()
        self.to_server.clear()
        self.to_client.clear()
        self.session: SimSession = self.manager.connect()
        self.session.receive(b'p\necho off\n')
        self.session.output.clear()
        self.client.hear_login()

    @rule()
    def lose_an_answer(self) -> None:
        """The Fleet Manager carries out commands, and the link is lost before its answer."""
        self.carry_to_server(10_000)
        self.connect()

    @rule()
    def restart_manager(self) -> None:
        self.manager.shut_down()
        self.connect()

    @rule(which=PICK)
    def request(self, which: int) -> None:
        try:
            job = self.client.request(JOBS[which % len(JOBS)], f'request {self.count}')
        except OSError:
            assert self.is_full
            return
        assert job.id not in self.wanted, 'an id is used twice'
        assert job.id in self.disk, 'a job is promised before it is stored'
        self.wanted[job.id] = which

    @rule(which=PICK)
    def repeat_request(self, which: int) -> None:
        for job in self.client.jobs[which:which + 1]:
            assert self.client.request(job.stops, job.request).id == job.id

    @rule(which=PICK)
    def cancel(self, which: int) -> None:
        for job in self.client.jobs[which:which + 1]:
            try:
                self.client.cancel(job.id)
            except OSError:
                assert self.is_full

    @rule(which=PICK, goal=st.integers(0, 2), other=st.integers(0, 2),
          priority=st.sampled_from([None, 7, 30]))
    def modify(self, which: int, goal: int, other: int, priority: Optional[int]) -> None:
        jobs = [job for job in self.client.jobs if job.is_open] or self.client.jobs
        for job in jobs[which % len(jobs):][:1] if jobs else ():
            goals = [GOALS[goal], *[GOALS[other]] * len(job.stops)]
            stops = tuple(replace(stop, goal=name, priority=priority)
                          for stop, name in zip(job.stops, goals))
            try:
                assert self.client.modify(job.request, stops).id == job.id
            except OSError:
                assert self.is_full
            except WrongJob:
                assert not job.is_open or job.is_unwanted or job.wanted

    @rule(goal=st.integers(0, 1), other=st.integers(0, 1))
    def modify_what_is_queued(self, goal: int, other: int) -> None:
        """A job that the Fleet Manager has just queued gets other goals and priorities, so that
        one modification needs several commands. Random rules seldom cause this.
        """
        self.request(goal)
        self.carry_to_server(10_000)
        self.carry_to_client(1_000_000)
        self.modify(len([job for job in self.client.jobs if job.is_open]) - 1, goal, other, 30)

    def modified(self, segment: QueueSegment, goal: str, priority: int) -> None:
        """The Fleet Manager modifies a segment, and ends its drive."""
        assert (goal, priority) != (segment.goal, segment.priority), 'a drive ends for nothing'
        self.carry_out(segment, goal, priority)

    @rule()
    def fill_or_clear_disk(self) -> None:
        self.is_full = not self.is_full

    @rule(count=st.integers(1, 200))
    def carry_to_server(self, count: int) -> None:
        """Some bytes go to the Fleet Manager."""
        self.pump()
        data = bytes(self.to_server[:count])
        del self.to_server[:count]
        self.session.receive(data)
        self.check_manager()

    @rule(count=st.integers(1, 400))
    def carry_to_client(self, count: int) -> None:
        """Some bytes come from the Fleet Manager."""
        self.to_client += self.session.output
        self.session.output.clear()
        data = bytes(self.to_client[:count])
        lines = (self.unread + data if self.to_client else data)
        del self.to_client[:count]
        *whole, rest = lines.split(b'\r\n')
        self.unread = rest
        for line in whole:
            self.client.hear_line(line.decode(), self.now)
        for job in self.client.pop_changes():
            if job.state is HandedState.UNKNOWN and job.id not in self.seen:
                assert self.now - job.sent / 1000 > RESENT_WITHIN, f'{job} is lost'
        self.store_news()

    @property
    def unread(self) -> bytes:
        return self._unread.get(self.session, b'')

    @unread.setter
    def unread(self, data: bytes) -> None:
        self._unread = {self.session: data}

    _unread: Dict[SimSession, bytes] = {}

    @rule()
    def pump(self) -> None:
        try:
            lines = self.client.due(self.now)
        except OSError:
            assert self.is_full
            return
        for line in lines:
            self.to_server += line.encode() + b'\n'

    @rule(which=PICK, is_there=st.booleans())
    def end_drive(self, which: int, is_there: bool) -> None:
        self.robots[which % 2].end_drive(is_there)

    @property
    def now(self) -> float:
        return self.clock.now + self.slept

    @rule(drives=st.integers(0, 3))
    def wait(self, drives: int = 0) -> None:
        """Time passes. The Fleet Manager can distribute jobs, and the client can query."""
        self.clock.advance(self.clock.now + 0.2)
        for _ in range(drives):
            for robot in range(2):
                self.end_drive(robot, True)
            self.clock.advance(self.clock.now + 0.2)
        self.slept += ASKED_EVERY

    @rule(end=st.booleans())
    def work(self, end: bool) -> None:
        """All bytes on their way arrive; with `end`, the robots arrive, too."""
        for _ in range(2):
            self.carry_to_server(10_000)
            self.carry_to_client(1_000_000)
        for robot in range(2 if end else 0):
            self.end_drive(robot, True)
        self.wait()

    @rule()
    def wait_until_the_manager_forgets(self) -> None:
        """The Fleet Manager deletes the jobs that have ended, as it does after 60 minutes."""
        self.slept += 2 * RESENT_WITHIN
        self.manager.queue.segments = [one for one in self.manager.queue.segments if one.is_open]

    def store_news(self) -> None:
        try:
            self.client.store_news()
        except OSError:
            assert self.is_full

    def check_manager(self) -> None:
        for segment in self.manager.queue.segments:
            self.seen.setdefault(segment.job, set()).add(segment.id)
        for id, segments in self.seen.items():
            assert id in self.wanted, 'a job came that nobody had requested'
            assert len(segments) == len(JOBS[self.wanted[id] % len(JOBS)]), f'{id} is done twice'

    @property
    def seen(self) -> Dict[str, set]:
        """The ids of all segments that the Fleet Manager ever had, by job."""
        return self.__dict__.setdefault('_seen', {})

    def teardown(self) -> None:
        """From now on everything works: each job ends in its true state."""
        if not hasattr(self, 'manager'):
            return
        self.is_full = False
        for _ in range(20 + 12 * len(self.wanted)):
            self.work(True)
            if not any(job.is_open for job in self.client.jobs):
                break
        assert {job.id for job in self.client.jobs} == set(self.wanted), 'a job is lost'
        for job in self.client.jobs:
            self.check_end(job)

    def check_end(self, job: HandedJob) -> None:
        segments = [one for one in self.manager.queue.segments if one.job == job.id]
        found = [one.status for one in segments]
        assert not job.wanted and job.modification is not Modification.UNDER_WAY
        if len(segments) == len(job.stops):
            for one, stop in zip(segments, job.stops):
                assert one.goal == stop.goal and stop.priority in (None, one.priority), \
                    f'{job} is told, and not what the Fleet Manager does'
        assert not job.is_open, f'{job} does not end'
        if job.state is HandedState.REFUSED:
            assert job.id not in self.seen and 'nowhere' in job.reason
        elif job.state is HandedState.UNKNOWN:
            assert not found, 'the Fleet Manager knows a job that is called unknown'
        elif job.id not in self.seen:
            assert job.state is HandedState.CANCELLED and job.is_unwanted
        elif found:
            one = 'Cancelled' if 'Cancelled' in found else 'Completed'
            assert job.state is STATES[one], f'{job} has another end than {found}'


def run(machine: Type[HandedJobsInAnyOrder], examples: int) -> None:
    run_state_machine_as_test(machine, settings=settings(
        max_examples=examples, stateful_step_count=30, deadline=None, derandomize=True,
        phases=(Phase.generate,), report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck)))


def test_no_job_is_done_twice_none_is_lost_and_each_ends_in_its_true_state() -> None:
    run(HandedJobsInAnyOrder, 40)


class SendsAgainWithoutAsking(JobClient):
    """A faulty client: after a login it treats a job in doubt as a job that was never sent."""

    def hear_login(self) -> None:
        super().hear_login()
        for job in self.jobs:
            if job.state is HandedState.SENT:
                self._put(job.after(HandedEvent.NOT_KNOWN))


class SendsBeforeItStores(JobClient):
    """A faulty client: it sends a job before the job is stored as SENT."""

    def _keep(self, job: HandedJob) -> None:
        if job.state is HandedState.SENT:
            self._put(job)
        else:
            super()._keep(job)

    def store_news(self) -> None:
        """Stores nothing."""


class NeverAsks(JobClient):
    """A faulty client: after a login it treats a job in doubt as an accepted job."""

    def hear_login(self) -> None:
        super().hear_login()
        for job in self.jobs:
            if job.state is HandedState.SENT:
                self._put(job.after(HandedEvent.ACCEPTED))


class BelievesErrors(JobClient):
    """A faulty client: after an error it ends a job as completed, without a query."""

    def hear_line(self, text: str, now: float) -> None:
        question = self._question
        super().hear_line(text, now)
        if text.startswith('CommandErrorDescription') and question and question.job in self._errors:
            self._put(self._jobs[question.job].after(HandedEvent.COMPLETED))


class SendsAgainLater(JobClient):
    """A faulty client: it sends a job again even if "not known" comes late."""

    def _hear_not_known(self, job: HandedJob) -> None:
        self._put(job.after(HandedEvent.NOT_KNOWN))


class ModifiesWithoutAsking(JobClient):
    """A faulty client: after a login it does not query the segments of a job to be modified."""

    def _is_to_be_asked(self, job: HandedJob, now: float) -> bool:
        return not job.wanted and super()._is_to_be_asked(job, now)


class BelievesAnswersToModifications(JobClient):
    """A faulty client: after the answer about one value it ends the whole modification."""

    def hear_line(self, text: str, now: float) -> None:
        question, line = self._question, read_line(text)
        super().hear_line(text, now)
        if isinstance(line, AnswerEnd) and line.command == 'queuemodify' and question:
            job = self._jobs[question.job]
            self._put(replace(job, stops=job.wanted or job.stops, wanted=(),
                              modification=Modification.DONE))


@pytest.mark.parametrize('fault', [SendsAgainWithoutAsking, SendsBeforeItStores, NeverAsks,
                                   BelievesErrors, SendsAgainLater, ModifiesWithoutAsking,
                                   BelievesAnswersToModifications])
def test_a_planted_fault_is_found(fault: Type[JobClient]) -> None:
    @seed(0)  # with this seed, each fault is found soon
    class Faulty(HandedJobsInAnyOrder):
        Client = fault
    with pytest.raises(AssertionError):
        run(Faulty, 400)
