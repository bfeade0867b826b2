"""A job, its segments, and their status, which follows from the state of its mission.

A job is a mission of the fleet manager; each segment is one stop of the mission. A job has no state
of its own: `news_of` derives the status of each segment from the last status of the mission. A
segment keeps the status that was last sent to clients, because they get each change once, in
OMRON's order:

    change                              sent before it
    Pending -> InProgress Allocated     InProgress UnAllocated
    Pending -> InProgress Driving       InProgress UnAllocated, InProgress Allocated
    InProgress -> InProgress After...   as for InProgress Driving, if this was not sent
    InProgress -> Cancelled             Cancelling, Interrupted
    InProgress -> Pending               Interrupted; another robot gets it
    Interrupted -> InProgress           InProgress UnAllocated, InProgress Allocated
    anything -> Completed               as for InProgress Driving, if this was not sent
    another priority or goal            BeforeModify, AfterModify; then the status again
    another goal, InProgress            BeforeModify, InterruptedByModify, AfterModify; then
                                        Pending

The job determines the priority and the places of its mission. Whenever the mission shows other
values, a change is sent. So the change is repeated until the mission shows the values of the job,
even if several changes are under way at once.
Invariants: a final status never changes; a segment is Completed only if the mission counts its stop
as reached; segments are completed in their order.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import Callable, List, NamedTuple, Optional, Tuple

from omron_jobs.core.job_words import (
    AFTER,
    ALLOCATED,
    BEFORE,
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


class DriveAct(Enum):
    """The reported act of a robot. Clients are informed of the acts in the order below."""

    DRIVES = 'drives'
    WAITS = 'waits'     # in front of its goal, while steps run before it may enter
    WORKS = 'works'     # at its goal


class JobDrive(NamedTuple):
    """A robot, the vertex to which it drives or where it works, and its act."""

    robot: str
    vertex: int
    act: DriveAct = DriveAct.DRIVES


class JobMission(NamedTuple):
    """The mission of a job, as the fleet manager reports it.

    robot      -- the robot that serves it; empty: no robot does
    reached    -- number of its stops that are done
    priority   -- the priority in force
    places     -- the vertices of its stops, in force; empty: they are not known
    is_refusal -- whether the report says that a change was not done
    drive      -- what its robot does; None: this is not known
    """

    state: JobMissionState
    robot: str = ''
    reached: int = 0
    priority: int = 0
    places: Tuple[int, ...] = ()
    is_refusal: bool = False
    drive: Optional[JobDrive] = None


class Told(NamedTuple):
    """The status of a segment that was sent to clients. An empty `robot` is sent as None."""

    status: SegmentStatus
    substatus: str = NONE
    robot: str = ''


class Place(NamedTuple):
    """The goal of a segment: its name, and its vertex."""

    goal: str
    vertex: int


@dataclass(frozen=True)
class JobSegment:
    """One goal of a job.

    number -- unique among all segments, pickups and drop-offs
    ended  -- ms since 1970; 0: it has not ended
    other  -- the former place, if the mission may still have it; None: it has the new place
    """

    number: int
    kind: SegmentKind
    goal: str
    vertex: int
    priority: int
    told: Told = Told(SegmentStatus.PENDING)
    ended: int = 0
    other: Optional[Place] = None

    @property
    def id(self) -> str:
        """The id that clients know."""
        return f'{self.kind.value}{self.number}'


@dataclass(frozen=True)
class JobOrigin:
    """The record of the REST interface that requested a job.

    kind   -- type of the record
    key    -- its key; empty: the client gave none
    job_id -- the job id as the client gave it
    """

    kind: str
    key: str
    job_id: str
    default_priority: bool


@dataclass(frozen=True)
class QueuedJob:
    """One job.

    id       -- the client's job id, or JOB and the number of its first segment
    queued   -- ms since 1970; also the stamp of the request of its mission
    mission  -- id of the request
    is_known -- whether the fleet manager has the mission
    cancel   -- why it is to be cancelled (empty: without a reason); None: it is not to be cancelled
    robot    -- the robot that must serve it, by its client's wish or because of a swap; empty: any
    origin   -- the REST record that requested it; None: the job came over ARCL
    swap     -- number of the first segment of the job whose robot must serve this job; 0: no swap
    """

    id: str
    segments: Tuple[JobSegment, ...]
    queued: int
    mission: int
    is_known: bool = False
    cancel: Optional[str] = None
    robot: str = ''
    origin: Optional[JobOrigin] = None
    swap: int = 0

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
    """A change of a segment, which is sent to all clients."""

    job: str
    queued: int
    segment: JobSegment


def queued_segments(segments: Tuple[JobSegment, ...], robot: str = '') -> Tuple[JobSegment, ...]:
    """Returns the segments of a new job, each of which waits for the segment before it.

    robot -- the robot that must serve the job; clients see it from the beginning
    """
    return tuple(replace(one, told=_waiting(segments, k)._replace(robot=robot))
                 for k, one in enumerate(segments))


def carrier_to(job: QueuedJob, vertex: int) -> str:
    """Returns the robot whose next act, the drop-off at `vertex`, ends the job; empty: none.

    Such a robot carries the load of the job, so no other robot can get the job.
    """
    segment = job.current
    if segment is None or segment is not job.segments[-1] or job.cancel is not None:
        return ''
    told, is_dropoff = segment.told, segment.kind is SegmentKind.DROPOFF
    return told.robot if (is_dropoff and segment.vertex == vertex
                          and told.status is SegmentStatus.IN_PROGRESS) else ''


def _waiting(segments: Tuple[JobSegment, ...], index: int) -> Told:
    before = segments[index - 1] if index else None
    return Told(SegmentStatus.PENDING,
                NONE if before is None or before.told.status is SegmentStatus.COMPLETED
                else WAITS_FOR.format(before.id))


def news_of(job: QueuedJob, mission: JobMission, now: int
            ) -> Tuple[QueuedJob, List[SegmentChange]]:
    """Returns a job as its mission shows it, and the changes to send, in order.

    now -- ms since 1970
    """
    changes: List[SegmentChange] = []
    segments = list(job.segments)
    for k, segment in enumerate(segments):
        if segment.told.status.is_final:
            continue
        segment, reverted = _as_placed(job, segment, k, mission)
        changes += reverted
        for told in _course(segment.told, _target(job, tuple(segments), k, mission),
                            segment.kind):
            segment = replace(segment, told=told, ended=now if told.status.is_final else 0)
            changes.append(SegmentChange(job.id, job.queued, segment))
        segments[k] = segment
    return replace(job, segments=tuple(segments), is_known=True), changes


def _as_placed(job: QueuedJob, segment: JobSegment, index: int, mission: JobMission
               ) -> Tuple[JobSegment, List[SegmentChange]]:
    """Compares the new goal of a segment with the mission. Returns the segment and the changes to
    send. If the mission refused the new goal, or if it came too late, the segment gets its former
    goal back.
    """
    other = segment.other
    if other is None or index >= len(mission.places):
        return segment, []
    shown = mission.places[index]
    if shown == segment.vertex:
        return replace(segment, other=None), []
    is_late = index < mission.reached or not mission.state.is_open
    if shown != other.vertex or not (is_late or mission.is_refusal):
        return segment, []
    back = _replaced(segment, other)
    return back, _modification(job, segment, back)


def _replaced(segment: JobSegment, place: Place) -> JobSegment:
    return replace(segment, goal=place.goal, vertex=place.vertex,
                   other=Place(segment.goal, segment.vertex))


def _target(job: QueuedJob, segments: Tuple[JobSegment, ...], index: int, mission: JobMission
            ) -> Told:
    """Returns the status to show for a segment that has not ended."""
    before = segments[index].told
    if index < mission.reached or mission.state is JobMissionState.SUCCEEDED:
        return Told(SegmentStatus.COMPLETED, NONE, mission.robot or before.robot)
    if not mission.state.is_open:
        return _unfinished(job, before, mission.state)
    if index > mission.reached:
        return _waiting(segments, index)._replace(robot=job.robot)
    return _present(job, segments, index, mission)


def _unfinished(job: QueuedJob, before: Told, state: JobMissionState) -> Told:
    """Returns the status of a segment that was not completed when its mission ended."""
    if state is JobMissionState.FAILED:
        return Told(SegmentStatus.FAILED, NONE, before.robot)
    is_refused = state is not JobMissionState.CANCELLED
    return Told(SegmentStatus.CANCELLED, REFUSED_BY_FLEET if is_refused else job.cancel or NONE,
                before.robot)


def _present(job: QueuedJob, segments: Tuple[JobSegment, ...], index: int, mission: JobMission
             ) -> Told:
    """Returns the status of the segment that an open mission serves now."""
    before, state = segments[index].told, mission.state
    robot = mission.robot or before.robot
    if state is JobMissionState.CANCELLING or job.cancel is not None:
        is_begun = before.status is not SegmentStatus.PENDING
        return Told(SegmentStatus.CANCELLING, job.cancel or NONE, robot) if is_begun else before
    if not mission.robot:
        return (Told(SegmentStatus.IN_PROGRESS, UNALLOCATED)
                if state is JobMissionState.ACTIVE
                else _waiting(segments, index)._replace(robot=job.robot))
    if state is JobMissionState.ACTIVE:
        return _served(segments[index], robot, mission.drive)
    return Told(SegmentStatus.INTERRUPTED, NONE, robot)


def _served(segment: JobSegment, robot: str, drive: Optional[JobDrive]) -> Told:
    """Returns the status of a segment that a robot serves; a status never goes back."""
    course = _course_with(robot, segment.kind)
    seen = 1
    if drive is not None and (drive.robot, drive.vertex) == (robot, segment.vertex):
        seen += 1 + list(DriveAct).index(drive.act)
    told = course.index(segment.told) if segment.told in course else 0
    return course[max(seen, told)]


def _course_with(robot: str, kind: SegmentKind) -> List[Told]:
    return [Told(SegmentStatus.IN_PROGRESS, sub, robot)
            for sub in (UNALLOCATED, ALLOCATED, DRIVING, BEFORE[kind], AFTER[kind])]


def _course(before: Told, target: Told, kind: SegmentKind) -> List[Told]:
    """Returns the statuses to send, one after the other, up to the target.

    Returns nothing if the target was already sent.
    """
    if before == target:
        return []
    status, robot = target.status, target.robot
    interrupted = Told(SegmentStatus.INTERRUPTED, NONE, before.robot)
    told: List[Told] = []
    is_served = before.status is SegmentStatus.IN_PROGRESS
    course = _course_with(robot, kind)
    to_drive = course[course.index(before) + 1 if before in course else 0:3]
    if target in course[1:]:
        if is_served and before.robot not in ('', robot):
            told = [interrupted]
        told += to_drive[:to_drive.index(target)] if target in to_drive else to_drive
    elif status is SegmentStatus.COMPLETED:
        if before.status is not SegmentStatus.CANCELLING:
            told = to_drive
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
    """Returns the mission to show if the fleet manager does not know a job's mission any more."""
    return JobMission(JobMissionState.FAILED, '', done(job))


def first_misplaced(job: QueuedJob, mission: JobMission) -> Optional[int]:
    """Returns the index of the first open segment to which the mission gives another place.

    Returns None if there is no such segment.

    A mission with another number of stops was changed by a person: it is not changed back.
    """
    if len(mission.places) != len(job.segments):
        return None
    return next((k for k, one in enumerate(job.segments)
                 if k >= mission.reached and one.vertex != mission.places[k]), None)


def with_priority(job: QueuedJob, number: int, priority: int
                  ) -> Tuple[QueuedJob, List[SegmentChange]]:
    """Returns a job with another priority of a segment, and the changes to send."""
    return _modified(job, number, lambda old: replace(old, priority=priority))


def with_goal(job: QueuedJob, number: int, place: Place) -> Tuple[QueuedJob, List[SegmentChange]]:
    """Returns a job with another goal of a segment, and the changes to send."""
    def modified(old: JobSegment) -> JobSegment:
        new = _replaced(old, place)
        is_served = old.told.status is SegmentStatus.IN_PROGRESS
        return replace(new, told=Told(SegmentStatus.PENDING)) if is_served else new
    return _modified(job, number, modified)


def _modified(job: QueuedJob, number: int, change: Callable[[JobSegment], JobSegment]
              ) -> Tuple[QueuedJob, List[SegmentChange]]:
    changes: List[SegmentChange] = []
    segments = list(job.segments)
    for k, old in enumerate(segments):
        if old.number == number:
            segments[k] = change(old)
            changes = _modification(job, old, segments[k])
    return replace(job, segments=tuple(segments)), changes


def _modification(job: QueuedJob, old: JobSegment, new: JobSegment) -> List[SegmentChange]:
    """Returns the changes to send when a segment is modified."""
    robot = old.told.robot
    told = [replace(old, told=old.told._replace(status=SegmentStatus.BEFORE_MODIFY))]
    if new.told.status is not old.told.status:
        told.append(replace(old, told=Told(SegmentStatus.INTERRUPTED_BY_MODIFY, NONE, robot)))
    told += [replace(new, told=Told(SegmentStatus.AFTER_MODIFY, NONE, robot)), new]
    return [SegmentChange(job.id, job.queued, one) for one in told]
