"""The indices of the kept jobs, and the questions about many silent missions."""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, List, Tuple

from hypothesis import given
from hypothesis import strategies as st
from job_fleet import Disk

from omron_jobs.core.job_book import QUESTIONS, SILENCE, JobBook, JobGoal
from omron_jobs.core.job_shelf import JobShelf
from omron_jobs.core.job_words import SegmentKind, SegmentStatus
from omron_jobs.core.jobs import (
    JobMission,
    JobMissionState,
    JobSegment,
    QueuedJob,
    SegmentChange,
    Told,
)

GOAL = JobGoal(SegmentKind.PICKUP, 'x', 1, 10)


def job(number: int, ended: int = 0) -> QueuedJob:
    told = Told(SegmentStatus.COMPLETED if ended else SegmentStatus.PENDING)
    return QueuedJob(f'Job{number}', (
        JobSegment(number, SegmentKind.PICKUP, 'x', 1, 10, told, ended),), 1, 100 - number)


@given(st.lists(st.tuples(st.integers(1, 9), st.sampled_from(('put', 'end', 'forget')))),
       st.integers(0, 40), st.integers(0, 4))
def test_the_shelf_is_a_list_of_jobs_in_each_order(
        acts: List[Tuple[int, str]], since: int, most: int) -> None:
    shelf, plain = JobShelf(()), {}
    changed: List[int] = []
    shelf.on_change = changed.append
    for now, (number, act) in enumerate(acts, 1):
        one, is_ended = job(number), number in plain and not plain[number].is_open
        if act == 'put' and number not in plain:
            plain[number] = one
            shelf.put(one)
        elif act == 'end' and number in plain and not is_ended:
            plain[number] = job(number, now)
            shelf.put(plain[number])
        elif act == 'forget' and is_ended:
            del plain[number]
            shelf.forget(one.mission)
    running = [one for one in plain.values() if one.is_open]
    assert list(shelf.all) == list(plain.values()) and list(shelf.open) == running
    assert shelf.open_ids == {one.id.lower() for one in running}
    ended = sorted((one.segments[0].ended, one.mission) for one in plain.values()
                   if not one.is_open)
    assert shelf.too_old(since, most) == [
        mission for k, (end, mission) in enumerate(ended) if end < since or k < len(ended) - most]
    assert {one.mission for one in plain.values()} <= set(changed)
    again = JobShelf(reversed(list(plain.values())))
    assert sorted(one.id for one in again.all) == sorted(one.id for one in plain.values())
    assert again.too_old(since, most) == shelf.too_old(since, most)


def test_a_thousand_silent_missions_are_asked_for_in_turn_and_those_that_are_served_first() -> None:
    numbers = iter(range(1, 10 ** 6))
    book = JobBook((), Disk().counters, Disk(), lambda: 1, lambda: next(numbers))
    for k in range(1000):
        one = book.queue([GOAL])
        state = JobMissionState.ACTIVE if k in (500, 700) else JobMissionState.PENDING
        book.hear(one.mission, one.queued, JobMission(state, 'r', 0, 10, (1,)), 0.0)
    assert not book.silent(SILENCE - 0.1)
    asked: Dict[int, List[float]] = {}
    at_first = [message.job.mission for message in book.silent(SILENCE)]
    assert at_first[:2] == [501, 701]
    ticks = [SILENCE + 0.2 * k for k in range(1, 520)]
    for now in ticks:
        for message in book.silent(now):
            asked.setdefault(message.job.mission, []).append(now)
    rate = sum(map(len, asked.values())) / (ticks[-1] - SILENCE)
    assert 0.95 * QUESTIONS < rate < 1.05 * QUESTIONS
    assert len(asked.keys() | set(at_first)) == 1000, 'a mission is never asked for'
    assert len(asked[501]) >= 9, 'one that is served waits for those that are not'


def test_a_change_is_written_once_for_all_clients_and_nothing_is_written_without_one(
        monkeypatch) -> None:
    from omron_jobs.core import client_session
    written: List[SegmentChange] = []
    monkeypatch.setattr(client_session, 'update_line',
                        lambda change: written.append(change) or 'QueueUpdate: x')
    server = client_session.JobServer(None, b'p')
    sessions = [server.connect(client_session.ClientPhase.OPEN) for _ in range(20)]
    server.announce(())
    assert not any(one.output for one in sessions)
    change = SegmentChange('JOB1', 1, replace(job(1).segments[0]))
    server.announce([change])
    assert written == [change]
    assert {bytes(one.output) for one in sessions} == {b'QueueUpdate: x\r\n'}
