"""Jobs over a real link on loopback: wherever the link is lost, each job is done once, and its true
state is shown.
"""
from __future__ import annotations

import time
from dataclasses import replace
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import pytest
from simulated_manager import Cut, ManagerPort

from omron_arcl import Backoff, LinkPhase
from omron_arcl.errors import ConnectionLost
from omron_arcl.help_list import HelpList
from omron_arcl.session import LoggedIn
from omron_jobs.client import job_client
from omron_jobs.client.fleet_manager_lines import WrongJob
from omron_jobs.client.handed_jobs import (
    HandedJob,
    HandedState,
    HandedStop,
    HandedStopKind,
    Modification,
)
from omron_jobs.client.job_client import JobClient
from omron_jobs.network import job_handover
from omron_jobs.network.job_handover import JobHandover

STOPS = (HandedStop('x', HandedStopKind.PICKUP), HandedStop('y', HandedStopKind.DROPOFF))
CUTS = (
    Cut(b'Enter'), Cut(b'p', is_heard=True), Cut(b'Commands:'), Cut(b'queuePickupDropoff'),
    Cut(b'echo', is_heard=True, is_delivered=True), Cut(b'Echo turned off.\r\n'),
    Cut(b'queuepickupdropoff', is_heard=True),
    Cut(b'queuepickupdropoff', is_heard=True, is_delivered=True),
    Cut(b'queuepickupdropoff goals "x"'), Cut(b'successfully queued'), Cut(b'Pending None'),
    Cut(b'UnAllocated'), Cut(b'1 10 InProgress Driv'), Cut(b'Completed'), Cut(b'20 InProgress Dri'))


def wait_for(condition: Callable[[], bool], what: str, timeout: float = 20.0) -> None:
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, f'{what} did not come'
        time.sleep(0.002)


class Site:
    """A program that hands over jobs, with its disk; it can be started again."""

    def __init__(self, port: int, password: bytes = b'p', silence: float = 6.0,
                 wrong_password: float = 0.05) -> None:
        self.disk: Dict[str, HandedJob] = {}
        self.told: List[HandedJob] = []
        self.is_full, self.count = False, 0
        self._args = (port, password, silence, wrong_password)
        self.start()

    def start(self) -> None:
        port, password, silence, wrong = self._args
        jobs = JobClient(self.disk.values(), self._store, lambda: int(time.time() * 1000), self._id)
        self.handover = JobHandover(jobs, '127.0.0.1', port, password, self.told.append,
                                    silence=silence,
                                    backoff=Backoff(0.01, 0.05, wrong_password=wrong))
        self.handover.start()

    def _id(self) -> str:
        self.count += 1
        return f'ROS{self.count}'

    def _store(self, jobs: Sequence[HandedJob]) -> None:
        if self.is_full:
            raise OSError(28, 'No space left on device')
        self.disk = {job.id: job for job in jobs}

    def job(self, id: str) -> HandedJob:
        return next(job for job in self.handover.jobs if job.id == id)

    def wait_end(self, id: str) -> HandedJob:
        wait_for(lambda: not self.job(id).is_open, f'the end of {id}')
        return self.job(id)

    def __enter__(self) -> Site:
        return self

    def __exit__(self, *_: object) -> None:
        self.handover.close()


def done(port: ManagerPort, id: str) -> List[Tuple[str, str]]:
    """The goals and ends of all segments that the Fleet Manager had for a job."""
    return [(one.goal, one.status) for one in port.manager.queue.segments if one.job == id]


@pytest.mark.parametrize('restarts', [False, True])
@pytest.mark.parametrize('cut', CUTS, ids=str)
def test_a_job_is_done_once_wherever_the_link_is_lost(cut: Cut, restarts: bool) -> None:
    with ManagerPort() as port:
        port.cut = cut
        with Site(port.port) as site:
            job = site.handover.request(STOPS, 'pallet 7')
            wait_for(lambda: port.cut is None, f'{cut}')
            if restarts:
                site.handover.close()
                site.start()
                assert site.handover.request(STOPS, 'pallet 7').id == job.id
            assert site.wait_end(job.id).state is HandedState.COMPLETED
            assert done(port, job.id) == [('x', 'Completed'), ('y', 'Completed')]
            states = [told.state for told in site.told]
            assert states[0] is HandedState.STORED and states[-1] is HandedState.COMPLETED
            assert states.count(HandedState.COMPLETED) == 1
            assert port.logins >= 2


def test_a_job_in_doubt_is_asked_for_before_a_new_one_is_sent() -> None:
    with ManagerPort() as port:
        port.drives = False
        port.cut = Cut(b'queuepickupdropoff', is_heard=True, is_delivered=True)
        with Site(port.port) as site:
            first = site.handover.request(STOPS, '')
            second = site.handover.request(STOPS, '')
            wait_for(lambda: site.job(second.id).state >= HandedState.ACCEPTED, 'the second job')
            said = [line.split()[0] for line in port.commands('queue')]
            assert said[:3] == ['queuePickupDropoff', 'queueQuery', 'queuePickupDropoff']
            assert len(done(port, first.id)) == len(done(port, second.id)) == 2


def test_a_refused_login_is_told_and_no_job_is_sent() -> None:
    with ManagerPort('right') as port, Site(port.port, b'wrong') as site:
        job = site.handover.request(STOPS, '')
        wait_for(lambda: site.handover.link.phase is LinkPhase.WRONG_PASSWORD, 'the refusal')
        wait_for(lambda: port.logins >= 2, 'another attempt')
        assert site.job(job.id).state is HandedState.STORED and not port.commands('queue')
        port.manager.password = 'wrong'         # a person gives the Fleet Manager this password
        assert site.wait_end(job.id).state is HandedState.COMPLETED
        assert len(done(port, job.id)) == 2


def test_lines_that_come_byte_by_byte_are_whole_lines() -> None:
    with ManagerPort() as port:
        port.chunk = 1
        with Site(port.port) as site:
            job = site.handover.request(STOPS, '')
            assert [(one.id, one.status) for one in site.wait_end(job.id).segments] == [
                ('PICKUP1', 'Completed'), ('DROPOFF2', 'Completed')]
            assert port.logins == 1


def test_half_a_line_before_a_loss_is_no_part_of_the_next_link() -> None:
    with ManagerPort() as port:
        port.drives = False
        port.cut = Cut(b'QueueUpdate: PICKUP1 ROS1 10 Pend')
        with Site(port.port) as site:
            job = site.handover.request(STOPS, '')
            wait_for(lambda: port.logins == 2 and bool(site.job(job.id).segments), 'the answer')
            assert [one.id for one in site.job(job.id).segments] == ['PICKUP1', 'DROPOFF2']


def test_a_burst_of_lines_about_others_jobs_delays_nothing_else() -> None:
    line = (b'QueueUpdate: PICKUP7 other%d 10 Completed None Goal "z" "Lynx1" 12/19/2011 06:54:18 '
            b'12/19/2011 06:54:34 0\r\n')
    with ManagerPort() as port, Site(port.port) as site:
        wait_for(lambda: site.handover.link.connected, 'the link')
        port.before = b''.join(line % n for n in range(5000)) + b'x' * 20_000 + b'\r\n\xff\x00\r\n'
        job = site.handover.request(STOPS, '')
        assert site.wait_end(job.id).state is HandedState.COMPLETED
        assert port.logins == 1 and {told.id for told in site.told} == {job.id}


def test_a_burst_of_jobs_is_handed_over_one_by_one_in_order() -> None:
    with ManagerPort() as port:
        port.drives = False
        with Site(port.port) as site:
            jobs = [site.handover.request(STOPS, '') for _ in range(50)]
            wait_for(lambda: site.job(jobs[-1].id).state >= HandedState.ACCEPTED, 'the last job')
            sent = [line.split()[-1] for line in port.commands('queuePickupDropoff')]
            assert sent == [job.id for job in jobs]


def test_a_silent_fleet_manager_is_left_and_the_job_asked_for() -> None:
    with ManagerPort() as port, Site(port.port, silence=0.5) as site:
        wait_for(lambda: site.handover.link.connected, 'the link')
        port.mute = True
        job = site.handover.request(STOPS, '')
        wait_for(lambda: port.logins >= 2, 'a new link')
        port.mute = False
        assert site.wait_end(job.id).state is HandedState.COMPLETED
        assert len(done(port, job.id)) == 2 and len(port.commands('queuePickupDropoff')) == 1


def test_a_sign_of_life_keeps_an_idle_link(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job_handover, 'BEAT', 0.05)
    with ManagerPort() as port, Site(port.port, silence=0.6):
        wait_for(lambda: len(port.commands('getDateTime')) > 4, 'signs of life')
        assert port.logins == 1


def test_an_answer_that_is_overdue_ends_the_link(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job_handover, 'BEAT', 0.05)
    monkeypatch.setattr(job_client, 'ANSWERED_WITHIN', 0.3)
    with ManagerPort() as port, Site(port.port) as site:
        port.swallowed = b'queuepickupdropoff'
        job = site.handover.request(STOPS, '')
        wait_for(lambda: port.logins == 2, 'a new link')
        port.swallowed = None
        assert site.wait_end(job.id).state is HandedState.COMPLETED
        assert len(done(port, job.id)) == 2


def test_nothing_is_sent_while_the_disk_is_full_and_the_reason_is_told() -> None:
    with ManagerPort() as port, Site(port.port) as site:
        wait_for(lambda: site.handover.link.connected, 'the link')
        site.is_full = True
        with pytest.raises(OSError):
            site.handover.request(STOPS, '')
        site.is_full = False
        port.drives = False
        job = site.handover.request(STOPS, '')
        wait_for(lambda: site.job(job.id).state is HandedState.IN_PROGRESS, 'a drive')
        site.is_full = True
        port.drives = True
        wait_for(lambda: 'No space left' in site.handover.problem, 'the reason')
        site.is_full = False
        wait_for(lambda: not site.disk[job.id].is_open, 'the end on the disk')
        wait_for(lambda: not site.handover.problem, 'the end of the problem')


def test_a_cancelled_job_ends_as_cancelled_and_one_that_was_not_sent_at_once() -> None:
    with ManagerPort() as port:
        port.drives = False
        with Site(port.port) as site:
            job = site.handover.request(STOPS, '')
            wait_for(lambda: site.job(job.id).state is HandedState.IN_PROGRESS, 'a drive')
            site.handover.cancel(job.id)
            assert site.wait_end(job.id).state is HandedState.CANCELLED
            assert {status for _, status in done(port, job.id)} == {'Cancelled'}
            site.handover.close()
            late: Optional[HandedJob] = site.handover.request(STOPS, '')
            assert late is not None
            site.handover.cancel(late.id)
            assert site.job(late.id).state is HandedState.CANCELLED


def test_a_swap_is_told_with_the_job_that_it_follows() -> None:
    with ManagerPort() as port:
        port.drives = False
        with Site(port.port) as site:
            first = site.handover.request(STOPS, '')
            wait_for(lambda: site.job(first.id).state is HandedState.IN_PROGRESS, 'a drive')
            swap = site.handover.request((replace(STOPS[0], goal='y'), replace(STOPS[1], goal='x')),
                                         '')
            wait_for(lambda: site.job(swap.id).linked == first.id, 'the link')
            assert site.job(first.id).linked == ''
            port.drives = True
            assert site.wait_end(swap.id).state is HandedState.COMPLETED
            assert site.job(first.id).state is HandedState.COMPLETED


MODIFIED = (replace(STOPS[0], priority=30), replace(STOPS[1], goal='x', priority=5))


@pytest.mark.parametrize('cut', [
    Cut(b'queuemodify', is_heard=True), Cut(b'queuemodify', is_heard=True, is_delivered=True),
    Cut(b'queuemodify modi'), Cut(b'BeforeModify'), Cut(b'AfterModify'), Cut(b'5 Pending'), None],
    ids=str)
def test_a_modification_is_carried_out_once_wherever_the_link_is_lost(cut: Optional[Cut]) -> None:
    with ManagerPort() as port:
        port.drives = False
        with Site(port.port) as site:
            job = site.handover.request(STOPS, 'pallet 7')
            wait_for(lambda: site.job(job.id).state is HandedState.IN_PROGRESS, 'a drive')
            port.cut = cut
            site.handover.modify('pallet 7', MODIFIED)
            wait_for(lambda: not site.job(job.id).wanted, 'the end of the modification')
            assert site.job(job.id).modification is Modification.DONE
            assert port.cut is None
            segments = port.manager.queue.segments
            assert [(one.goal, one.priority) for one in segments] == [('x', 30), ('x', 5)]
            assert len(port.commands('queueModify')) == 3
            port.drives = True
            assert site.wait_end(job.id).stops == MODIFIED


def test_a_modification_that_is_refused_leaves_the_job_and_tells_why() -> None:
    with ManagerPort() as port:
        port.drives = False
        with Site(port.port) as site:
            job = site.handover.request(STOPS, 'pallet 7')
            wait_for(lambda: site.job(job.id).state is HandedState.IN_PROGRESS, 'a drive')
            site.handover.modify('pallet 7', (STOPS[0], replace(STOPS[1], goal='nowhere')))
            wait_for(lambda: not site.job(job.id).wanted, 'the end of the modification')
            found = site.job(job.id)
            assert found.modification is Modification.REFUSED and found.stops == STOPS
            assert 'no such goal "nowhere"' in found.reason
            port.drives = True
            assert site.wait_end(job.id).state is HandedState.COMPLETED


def test_a_job_that_was_not_sent_is_modified_at_once() -> None:
    with ManagerPort('right') as port, Site(port.port, b'wrong') as site:
        site.handover.request(STOPS, 'pallet 7')
        job = site.handover.modify('pallet 7', MODIFIED)
        assert (job.stops, job.modification) == (MODIFIED, Modification.DONE)
        assert not port.commands('queue')


@pytest.mark.parametrize('request_id, stops, words', [
    ('', MODIFIED, 'no job'), ('other', MODIFIED, 'no job'),
    ('pallet 7', MODIFIED[:1], 'other pickups and drop-offs'),
    ('pallet 7', (MODIFIED[0], replace(MODIFIED[1], goal='x" y')), 'no name of a goal')])
def test_a_wrong_modification_changes_nothing(
        request_id: str, stops: Tuple[HandedStop, ...], words: str) -> None:
    client = JobClient([HandedJob('ROS1', STOPS, 'pallet 7')], lambda jobs: None, lambda: 0,
                       lambda: 'ROS2')
    with pytest.raises(WrongJob, match=words):
        client.modify(request_id, stops)
    assert client.jobs == [HandedJob('ROS1', STOPS, 'pallet 7')]


def test_what_was_not_sent_over_a_lost_link_is_not_sent_over_the_next_one() -> None:
    client = JobClient([replace(HandedJob('ROS1', STOPS), state=HandedState.ACCEPTED)],
                       lambda jobs: None, lambda: 0, lambda: 'ROS2')
    handover = JobHandover(client, '127.0.0.1', 1, b'p', lambda job: None)
    login = LoggedIn(HelpList({}, complete=False))
    handover.hear_login(login, 0.0)
    handover.cancel('ROS1')
    for _ in range(2):
        assert handover.next_to_send(0.0) == b'queueCancel jobId ROS1'
        handover.hear_loss(ConnectionLost('cut'))
        handover.hear_login(login, 0.0)
    handover.close()
