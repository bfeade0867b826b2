"""The client of this package gives jobs to its server, with losses and restarts in any order.

Client and server have separate tables of words: a difference between the tables shows here. Each
job is driven once, and ends in the same state at the client and at the server.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, List, Optional, Tuple

from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    rule,
    run_state_machine_as_test,
)
from job_fleet import Disk, FakeFleet, Key, tell
from proofs import is_whole

from omron_jobs.client.fleet_manager_lines import WrongJob
from omron_jobs.client.handed_jobs import (
    HandedJob,
    HandedState,
    HandedStop,
    HandedStopKind,
    Modification,
)
from omron_jobs.client.job_client import JobClient
from omron_jobs.core.client_session import ClientSession, JobServer
from omron_jobs.core.job_book import JobBook
from omron_jobs.core.job_commands import JobCommands, JobSite
from omron_jobs.core.jobs import JobMissionState

P, D = HandedStopKind.PICKUP, HandedStopKind.DROPOFF
JOBS: Tuple[Tuple[HandedStop, ...], ...] = (
    (HandedStop('x', P),), (HandedStop('x', P, 5), HandedStop('y', D)),
    (HandedStop('y', P), HandedStop('x', D)),
    (HandedStop('x', P), HandedStop('y', D, 3), HandedStop('x', D)),
    (HandedStop('nowhere', P),))
PICK = st.integers(0, 30)
ENDS = {'Completed': HandedState.COMPLETED, 'Cancelled': HandedState.CANCELLED}


class ClientAgainstServer(RuleBasedStateMachine):
    @initialize()
    def begin(self) -> None:
        self.disk, self.fleet = Disk(), FakeFleet()
        self.client_disk: Dict[str, HandedJob] = {}
        self.now, self.count = 0.0, 0
        self.missions = iter(range(1, 10 ** 6))
        self.start_server()
        self.start_client()

    def start_server(self) -> None:
        self.book = JobBook(self.disk.jobs.values(), self.disk.counters, self.disk,
                            lambda: 1 + int(self.now * 1000), lambda: next(self.missions))
        site = JobSite()
        site.goals = {'x': 1, 'y': 2, 'z': 3}
        self.server = JobServer(JobCommands(self.book, site), b'p')

    def start_client(self) -> None:
        self.client = JobClient(self.client_disk.values(), self.store,
                                lambda: 1 + int(self.now * 1000), self.new_id)
        self.connect()

    def store(self, jobs: List[HandedJob]) -> None:
        self.client_disk = {job.id: job for job in jobs}

    def new_id(self) -> str:
        self.count += 1
        return f'ROS{self.count}'

    def connect(self) -> None:
        self.session: ClientSession = self.server.connect()
        self.session.receive(b'p\necho off\n')
        self.session.output.clear()
        self.client.hear_login()

    # -- the client --------------------------------------------------------------------------------

    @rule(which=PICK)
    def request(self, which: int) -> None:
        self.client.request(JOBS[which % len(JOBS)], f'request {self.count}')

    @rule(which=PICK, goal=st.sampled_from('xyz'), priority=st.sampled_from([None, 7, 30]))
    def modify(self, which: int, goal: str, priority: Optional[int]) -> None:
        jobs = [job for job in self.client.jobs if job.is_open]
        for job in jobs[which % len(jobs):][:1] if jobs else ():
            stops = (*job.stops[:-1], replace(job.stops[-1], goal=goal, priority=priority))
            try:
                self.client.modify(job.request, stops)
            except WrongJob:
                assert job.wanted or job.is_unwanted

    @rule(which=PICK)
    def cancel(self, which: int) -> None:
        for job in self.client.jobs[which:which + 1]:
            self.client.cancel(job.id)

    @rule(is_answered=st.booleans())
    def talk(self, is_answered: bool) -> None:
        """The client sends the lines that are due. It gets the answers if `is_answered`; if not,
        the link is lost.
        """
        for _ in range(30):
            lines = self.client.due(self.now)
            if not lines:
                return
            self.session.receive(''.join(f'{line}\n' for line in lines).encode())
            self.exchange()
            if not is_answered:
                self.lose_link()
                return
            self.hear()

    def hear(self) -> None:
        *lines, rest = self.session.output.decode().split('\r\n')
        assert not rest
        self.session.output.clear()
        for line in lines:
            self.client.hear_line(line, self.now)
        assert not self.client.problem
        self.client.store_news()

    @rule()
    def lose_link(self) -> None:
        self.session.close()
        self.connect()

    @rule()
    def restart_client(self) -> None:
        self.session.close()
        self.start_client()

    @rule()
    def restart_server(self) -> None:
        self.start_server()
        self.connect()

    @rule()
    def wait(self) -> None:
        self.now += 11.0

    # -- the fleet ---------------------------------------------------------------------------------

    def exchange(self) -> None:
        for message in self.book.due(self.now) + self.book.silent(self.now):
            for key, shown in list(self.fleet.handle(message)):
                self.server.announce(tell(self.book, key, shown, self.now))
        self.book.store_news()

    @rule(which=PICK, is_there=st.booleans())
    def drive(self, which: int, is_there: bool) -> None:
        open_ones = [key for key, one in self.fleet.missions.items() if one.shown.state.is_open]
        for key in open_ones[which % len(open_ones):][:1] if open_ones else ():
            self.serve(key, is_there)

    def serve(self, key: Key, is_there: bool) -> None:
        self.fleet.set(key, JobMissionState.ACTIVE, self.fleet.missions[key].shown.robot or 'r1')
        self.server.announce(tell(self.book, key, self.fleet.missions[key].shown, self.now))
        self.server.announce(self.book.hear_drives(self.fleet.drives()))
        if is_there:
            self.fleet.reach(key)
            self.server.announce(tell(self.book, key, self.fleet.missions[key].shown, self.now))
        self.book.store_news()

    # -- what holds --------------------------------------------------------------------------------

    def teardown(self) -> None:
        if not hasattr(self, 'client'):
            return
        for _ in range(20 + 5 * self.count):
            self.now += 11.0
            self.talk(True)
            self.exchange()
            for key, mission in list(self.fleet.missions.items()):
                if mission.shown.state.is_open:
                    self.serve(key, True)
            self.hear()
            if not any(job.is_open for job in self.client.jobs):
                break
        assert len(self.fleet.driven) == len(set(self.fleet.driven))
        assert len(self.client.jobs) == self.count, 'a job is lost'
        for job in self.client.jobs:
            self.check_end(job)

    def check_end(self, job: HandedJob) -> None:
        found = [one for one in self.book.jobs if one.id == job.id]
        assert not job.is_open and len(found) <= 1, f'{job} is open or doubled'
        assert job.modification is not Modification.UNDER_WAY and not job.wanted
        if not found:
            assert (job.state is HandedState.CANCELLED and job.is_unwanted
                    or job.state is HandedState.REFUSED and 'nowhere' in job.reason), f'{job}'
            return
        segments = found[0].segments
        ends = {one.told.status.value for one in segments}
        assert job.state is ENDS['Cancelled' if 'Cancelled' in ends else 'Completed'], f'{job}'
        assert [(one.id, one.goal) for one in job.segments] == [
            (one.id, one.goal) for one in segments]
        assert [stop.goal for stop in job.stops] == [one.goal for one in segments]


def test_each_job_is_driven_once_and_ends_at_the_client_as_at_the_server() -> None:
    run_state_machine_as_test(ClientAgainstServer, settings=settings(
        max_examples=300 if is_whole(__file__) else 25, stateful_step_count=25, deadline=None,
        derandomize=True, phases=(Phase.generate,), report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck)))


def test_a_swap_and_a_modification_are_understood() -> None:
    site = ClientAgainstServer()
    site.begin()
    first = site.client.request(JOBS[1], 'first')
    site.talk(True)
    site.drive(0, True)
    site.drive(0, False)    # the robot drives to the drop-off
    site.hear()
    swap = site.client.request(JOBS[2], 'swap')
    site.talk(True)
    linked = {job.id: job.linked for job in site.client.jobs}
    assert linked == {first.id: '', swap.id: first.id}
    site.client.modify('swap', (JOBS[2][0], replace(JOBS[2][1], goal='z', priority=8)))
    site.talk(True)
    job = next(job for job in site.client.jobs if job.id == swap.id)
    assert job.modification is Modification.DONE
    assert [(one.goal, one.priority) for one in job.segments] == [('y', 10), ('z', 8)]
    site.teardown()
