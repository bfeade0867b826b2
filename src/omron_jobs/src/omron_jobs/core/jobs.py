"""A job, its segments, and what the state of its mission says about them.

A job is a mission of the fleet manager, each segment one of its stops. A job has no state of its
own: `news_of` derives the status of each segment from the last status of the mission. A segment
keeps what was last told of it, because clients hear each change once, and in OMRON's order:

    change                              told on the way
    Pending -> InProgress Driving       InProgress UnAllocated, InProgress Allocated
    InProgress -> Cancelled             Cancelling, Interrupted
    InProgress -> Pending               Interrupted; another robot gets it
    Interrupted -> InProgress           InProgress UnAllocated, InProgress Allocated
    anything -> Completed               as to InProgress Driving, if that was not told

Invariants: a final status never changes; a segment is Completed only if the mission counts its stop
as reached; segments are completed in their order.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import List, NamedTuple, Optional, Tuple

from omron_jobs.core.job_words import (
    ALLOCATED,
    DRIVING,
    NONE,
    REFUSED_BY_FLEET,
    UNALLOCATED,
    WAITS_FOR,
    SegmentKind,
    SegmentStatus,
)


class JobMissionState(IntEnum):
    """The state of a mission, with the numbers of itrci_nav_msgs/MissionStatus."""

    PENDING = 0
    ACTIVE = 1
    SUCCEEDED = 2
    FAILED = 3
    REFUSED = 4
    CANCELLED = 5
    PAUSED = 6
    CANCELLING = 7
    NEEDS_PERSON = 8
    BLOCKED = 9
    PLANNED = 10
    EXPIRED = 11

    @property
    def is_open(self) -> bool:
        """Whether the mission has not ended."""
        return self not in _ENDED


_ENDED = frozenset((JobMissionState.SUCCEEDED, JobMissionState.FAILED, JobMissionState.REFUSED,
                    JobMissionState.CANCELLED, JobMissionState.EXPIRED))


class JobMission(NamedTuple):
    """What the fleet manager says of the mission of a job.

    robot   -- that serves it; empty: none does
    reached -- number of its stops that are done
    """

    state: JobMissionState
    robot: str = ''
    reached: int = 0


class Told(NamedTuple):
    """What clients were told of a segment. An empty robot is OMRON's None."""

    status: SegmentStatus
    substatus: str = NONE
    robot: str = ''


@dataclass(frozen=True)
class JobSegment:
    """One goal of a job.

    number -- no other segment has it, neither a pickup nor a drop-off
    ended  -- ms since 1970; 0: it has not ended
    """

    number: int
    kind: SegmentKind
    goal: str
    vertex: int
    priority: int
    told: Told = Told(SegmentStatus.PENDING)
    ended: int = 0

    @property
    def id(self) -> str:
        """The id that clients know."""
        return f'{self.kind.value}{self.number}'


@dataclass(frozen=True)
class QueuedJob:
    """One job.

    id       -- its job id: that of the client, or JOB and the number of its first segment
    queued   -- ms since 1970; also the stamp of the request of its mission
    mission  -- id of the request
    is_known -- the fleet manager has the mission
    cancel   -- why it is to be cancelled; None: it is not. Empty: no reason was given
    moved    -- its priority was changed, and the fleet manager was not told yet
    """

    id: str
    segments: Tuple[JobSegment, ...]
    queued: int
    mission: int
    is_known: bool = False
    cancel: Optional[str] = None
    moved: bool = False

    @property
    def is_open(self) -> bool:
        """Whether it has not ended."""
        return not self.segments[-1].told.status.is_final

    @property
    def current(self) -> Optional[JobSegment]:
        """The segment that is served or comes next; None: the job has ended."""
        return next((one for one in self.segments if not one.told.status.is_final), None)


@dataclass(frozen=True)
class SegmentChange:
    """A change of a segment that all clients are told."""

    job: str
    queued: int
    segment: JobSegment


def queued_segments(segments: Tuple[JobSegment, ...]) -> Tuple[JobSegment, ...]:
    """Returns the segments of a new job: each waits for the one before it."""
    return tuple(replace(one, told=_waiting(segments, k)) for k, one in enumerate(segments))


def _waiting(segments: Tuple[JobSegment, ...], index: int) -> Told:
    before = segments[index - 1] if index else None
    return Told(SegmentStatus.PENDING,
                NONE if before is None or before.told.status is SegmentStatus.COMPLETED
                else WAITS_FOR.format(before.id))


def news_of(job: QueuedJob, mission: JobMission, now: int
            ) -> Tuple[QueuedJob, List[SegmentChange]]:
    """Returns a job as its mission shows it, and the changes to be told, in order.

    now -- ms since 1970
    """
    changes: List[SegmentChange] = []
    segments = list(job.segments)
    for k, segment in enumerate(segments):
        if segment.told.status.is_final:
            continue
        for told in _course(segment.told, _target(job, tuple(segments), k, mission)):
            segment = replace(segment, told=told, ended=now if told.status.is_final else 0)
            changes.append(SegmentChange(job.id, job.queued, segment))
        segments[k] = segment
    return replace(job, segments=tuple(segments), is_known=True), changes


def _target(job: QueuedJob, segments: Tuple[JobSegment, ...], index: int, mission: JobMission
            ) -> Told:
    """What a segment that has not ended is to be shown as."""
    before, state = segments[index].told, mission.state
    robot = mission.robot or before.robot
    if index < mission.reached or state is JobMissionState.SUCCEEDED:
        return Told(SegmentStatus.COMPLETED, NONE, robot)
    if state is JobMissionState.FAILED:
        return Told(SegmentStatus.FAILED, NONE, before.robot)
    if not state.is_open:
        is_refused = state is not JobMissionState.CANCELLED
        return Told(SegmentStatus.CANCELLED,
                    REFUSED_BY_FLEET if is_refused else job.cancel or NONE, before.robot)
    if index > mission.reached:
        return _waiting(segments, index)
    if state is JobMissionState.CANCELLING or job.cancel is not None:
        is_begun = before.status is not SegmentStatus.PENDING
        return Told(SegmentStatus.CANCELLING, job.cancel or NONE, robot) if is_begun else before
    if not mission.robot:
        return (Told(SegmentStatus.IN_PROGRESS, UNALLOCATED)
                if state is JobMissionState.ACTIVE else _waiting(segments, index))
    if state is JobMissionState.ACTIVE:
        return Told(SegmentStatus.IN_PROGRESS, DRIVING, robot)
    return Told(SegmentStatus.INTERRUPTED, NONE, robot)


def _course(before: Told, target: Told) -> List[Told]:
    """What is told, one after the other, until the target is shown; nothing if it is already."""
    if before == target:
        return []
    status, robot = target.status, target.robot
    begun = [Told(SegmentStatus.IN_PROGRESS, sub, robot) for sub in (UNALLOCATED, ALLOCATED)]
    driving = Told(SegmentStatus.IN_PROGRESS, DRIVING, robot)
    interrupted = Told(SegmentStatus.INTERRUPTED, NONE, before.robot)
    told: List[Told] = []
    is_served = before.status is SegmentStatus.IN_PROGRESS
    if status is SegmentStatus.IN_PROGRESS and target.substatus == DRIVING:
        if is_served and before.robot not in ('', robot):
            told = [interrupted, *begun]
        elif not (is_served and before.substatus == ALLOCATED):
            told = begun[is_served and before == begun[0]:]
    elif status is SegmentStatus.COMPLETED:
        if not is_served and before.status is not SegmentStatus.CANCELLING:
            told = [*begun, driving]
    elif status is SegmentStatus.CANCELLED and before.status is not SegmentStatus.PENDING:
        cancelling = Told(SegmentStatus.CANCELLING, target.substatus, before.robot)
        told = ([] if before.status is SegmentStatus.CANCELLING else [cancelling]) + [interrupted]
    elif status is SegmentStatus.PENDING and is_served:
        told = [interrupted]
    return [*told, target]


def done(job: QueuedJob) -> int:
    """Returns the number of segments that are completed."""
    return sum(one.told.status is SegmentStatus.COMPLETED for one in job.segments)


def lost(job: QueuedJob) -> JobMission:
    """Returns what to show of a job whose mission the fleet manager does not know any more."""
    return JobMission(JobMissionState.FAILED, '', done(job))


def with_priority(job: QueuedJob, number: int, priority: int
                  ) -> Tuple[QueuedJob, List[SegmentChange]]:
    """Returns a job in which a segment has another priority, and the changes to be told."""
    changes: List[SegmentChange] = []
    segments = list(job.segments)
    for k, old in enumerate(segments):
        if old.number == number:
            segments[k] = new = replace(old, priority=priority)
            changes = [SegmentChange(job.id, job.queued, one) for one in (
                replace(old, told=old.told._replace(status=SegmentStatus.BEFORE_MODIFY)),
                replace(new, told=Told(SegmentStatus.AFTER_MODIFY, NONE, old.told.robot)), new)]
    return replace(job, moved=job.moved or job.segments[0].number == number,
                   segments=tuple(segments)), changes
