"""The queue of a simulated Fleet Manager: jobs, their segments, and the robots that serve them.

    status      event                                     next status
    Pending     it is due, and a robot is free            InProgress
                cancelled                                 Cancelled
                modified                                  BeforeModify, AfterModify, Pending
    InProgress  its robot has reached the goal            Completed
                its robot gave up                         Interrupted, then Pending again
                cancelled                                 Cancelling, Interrupted, Cancelled
                modified                                  BeforeModify, InterruptedByModify,
                                                          AfterModify, Pending

A pickup at the goal where a running job drops off is a swap: it waits for that drop-off, and the
same robot serves it, in the same second. The pickup no longer waits if the drop-off is not
completed, or if one of the two gets another goal.

Invariants: a robot serves one job at a time, except for a swap; one robot serves the segments of a
job, in their order. Words, ids and lines: OMRON's manual I617-E-01 p. 44-49 and 188-236.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, List, Optional, Protocol, Sequence, Tuple

FINAL = ('Completed', 'Cancelled')
NO_ROBOT = 'None'


class QueueRobot(Protocol):
    """A robot of the Fleet Manager."""

    name: str

    @property
    def is_free(self) -> bool:
        """Whether it may get a job."""

    def drive(self, goal: str, ended: Callable[[bool], None]) -> None:
        """Drives to a goal. Later calls `ended` once: True if the robot has reached the goal."""

    def stop(self) -> None:
        """Ends the drive."""


@dataclass
class QueueSegment:
    """A segment of a job. Its attributes are the fields of its lines, and two counters."""

    id: str
    job: str
    goal: str
    priority: int
    queued: str
    after: str = ''         # the segment that must be completed before this one
    status: str = 'Pending'
    substatus: str = 'None'
    robot: str = NO_ROBOT
    completed: str = 'None None'
    fails: int = 0
    drives: int = 0

    @property
    def is_open(self) -> bool:
        """Whether it has not ended."""
        return self.status not in FINAL


@dataclass(frozen=True)
class NewSegment:
    """A segment that a client wants to queue; `kind`: PICKUP or DROPOFF."""

    goal: str
    kind: str
    priority: int


class NotModifiable(ValueError):
    """A segment does not exist, has ended, or is ending. The text is its id."""


class DoubleJob(ValueError):
    """A new job has the id of an active job."""


@dataclass
class JobQueue:
    """All segments, the oldest first; calls `tell` after each change of a segment."""

    robots: Sequence[QueueRobot]
    date: Callable[[], str]
    tell: Callable[[QueueSegment], None] = lambda segment: None
    segments: List[QueueSegment] = field(default_factory=list)
    _count: int = 0

    def swap_at(self, goal: str) -> Optional[QueueSegment]:
        """Returns a drop-off at `goal` that belongs to a running job, and has no linked job yet."""
        taken = {one.after for one in self.segments if one.is_open}
        running = {one.job for one in self.segments if one.status == 'InProgress'}
        return next((one for one in self.segments if one.is_open and one.job in running
                     and one.goal == goal and one.id.startswith('DROPOFF')
                     and one.id not in taken), None)

    def add(self, wanted: Sequence[NewSegment], job: str,
            swap: Optional[QueueSegment] = None) -> List[QueueSegment]:
        """Queues a job and returns its segments; does not call `tell`. Raises DoubleJob."""
        if any(one.is_open and one.job.lower() == job.lower() for one in self.segments):
            raise DoubleJob(f'job id "{job}" is that of an active job')
        added: List[QueueSegment] = []
        job = job or f'JOB{self._count + 1}'
        for new in wanted:
            self._count += 1
            before = added[-1].id if added else ''
            added.append(QueueSegment(f'{new.kind}{self._count}', job, new.goal, new.priority,
                                      self.date(), before,
                                      substatus=f'ID_{before}' if before else 'None'))
        if swap is not None:
            robot = next(one.robot for one in self.segments
                         if one.job == swap.job and one.status == 'InProgress')
            added[0].after, added[0].substatus = swap.id, f'ID_{swap.id}'
            for one in added:
                one.robot = robot
        self.segments += added
        return added

    def check_modifiable(self, id: str) -> QueueSegment:
        """Returns the segment with that id, ignoring case. Raises NotModifiable."""
        found = next((one for one in self.segments if one.id.lower() == id.lower()), None)
        if found is None or found.status not in ('Pending', 'InProgress'):
            raise NotModifiable(id)
        return found

    def modify(self, segment: QueueSegment, goal: str, priority: int) -> None:
        """Gives a modifiable segment another goal or priority. If a robot drives for it, the drive
        ends, and the segment waits again.
        """
        was_driven, waited = segment.status == 'InProgress', segment.substatus
        self._enter(segment, 'BeforeModify', 'Driving' if was_driven else 'None')
        if was_driven:
            self._robot(segment.robot).stop()
            self._enter(segment, 'InterruptedByModify', 'None')
            segment.robot, waited = NO_ROBOT, 'None'
        is_elsewhere = goal != segment.goal
        segment.goal, segment.priority = goal, priority
        self._enter(segment, 'AfterModify', 'None')
        self._enter(segment, 'Pending', waited)
        if is_elsewhere:
            self._part(segment)
            for following in self.segments:
                if following.after == segment.id:
                    self._part(following)

    def announce(self, added: Sequence[QueueSegment]) -> None:
        """Calls `tell` for added segments. Must be called after the client has got its reply."""
        for one in added:
            self.tell(one)

    def find(self, kind: str, value: str) -> List[QueueSegment]:
        """Returns the segments with an id, jobId, robotName or status."""
        fields = {'id': 'id', 'jobid': 'job', 'robotname': 'robot', 'status': 'status'}
        return [one for one in self.segments
                if getattr(one, fields[kind.lower()]).lower() == value.lower()]

    def cancel(self, found: Sequence[QueueSegment], reason: str) -> None:
        """Cancels all open segments of the jobs to which these segments belong."""
        jobs = {one.job for one in found if one.is_open}
        for one in self.segments:
            if one.is_open and one.job in jobs:
                if one.status == 'InProgress':
                    self._enter(one, 'Cancelling', reason)
                    self._robot(one.robot).stop()
                    self._enter(one, 'Interrupted', 'None')
                one.completed = self.date()
                self._enter(one, 'Cancelled', reason)
        for one in self.segments:
            if one.after in {ended.id for ended in self.segments if ended.status == 'Cancelled'}:
                self._part(one)

    def advance(self) -> None:
        """Gives each free robot the segment that is due for it."""
        busy = {one.robot for one in self.segments if one.is_open and one.status != 'Pending'}
        for robot in self.robots:
            if robot.is_free and robot.name not in busy:
                due = self._next(robot.name)
                if due is not None:
                    self._begin(due, robot)

    def _next(self, robot: str) -> Optional[QueueSegment]:
        waiting = [one for one in self.segments
                   if (one.status, one.substatus) == ('Pending', 'None')
                   and self._owner(one) in (NO_ROBOT, robot)]
        return max(waiting, key=lambda one: one.priority) if waiting else None

    def _owner(self, segment: QueueSegment) -> str:
        """Returns the robot that must serve a segment: the one of the preceding segment."""
        return next((one.robot for one in self.segments if one.id == segment.after), NO_ROBOT)

    def _linked(self, job: str) -> List[QueueSegment]:
        """Returns the open segments of jobs that are linked to a job."""
        ids = {one.id for one in self.segments if one.job == job and one.is_open}
        jobs = {one.job for one in self.segments if one.after in ids and one.job != job}
        return [one for one in self.segments if one.is_open and one.job in jobs]

    def _part(self, segment: QueueSegment) -> None:
        """Ends a swap: the job waits for any robot, like other jobs."""
        before = next((one for one in self.segments if one.id == segment.after), None)
        if segment.is_open and before is not None and before.job != segment.job:
            segment.after, segment.substatus = '', 'None'
            for one in self.segments:
                if one.is_open and one.job == segment.job:
                    one.robot = NO_ROBOT
            self.tell(segment)

    def _begin(self, segment: QueueSegment, robot: QueueRobot, is_there: bool = False) -> None:
        self._enter(segment, 'InProgress', 'UnAllocated')
        segment.robot = robot.name
        for one in self._linked(segment.job):
            one.robot = robot.name
        self._enter(segment, 'InProgress', 'Allocated')
        self._enter(segment, 'InProgress', 'Driving')
        segment.drives += 1
        drive = segment.drives

        def ended(is_there: bool) -> None:
            if segment.status == 'InProgress' and segment.drives == drive:
                self._end(segment, robot, is_there)
        if is_there:
            self._end(segment, robot, True)
        else:
            robot.drive(segment.goal, ended)

    def _end(self, segment: QueueSegment, robot: QueueRobot, is_there: bool) -> None:
        if not is_there:
            self._enter(segment, 'Interrupted', 'None')
            segment.robot, segment.fails = NO_ROBOT, segment.fails + 1
            self._enter(segment, 'Pending', 'None')
            for following in self.segments:
                if following.after == segment.id:
                    self._part(following)
            return
        segment.completed = self.date()
        self._enter(segment, 'Completed', 'None')
        for following in self.segments:
            if following.after == segment.id and following.is_open:
                self._begin(following, robot, is_there=following.job != segment.job)

    def _enter(self, segment: QueueSegment, status: str, substatus: str) -> None:
        segment.status, segment.substatus = status, substatus
        self.tell(segment)

    def _robot(self, name: str) -> QueueRobot:
        return next(robot for robot in self.robots if robot.name == name)


def line_of(word: str, segment: QueueSegment, echo: Optional[str] = None) -> str:
    """Returns a line about a segment; `echo` is None for a QueueUpdate, which has no echo."""
    robot = f'"{segment.robot}"'
    parts: Tuple[str, ...] = (
        f'{word}:', segment.id, segment.job, str(segment.priority), segment.status,
        segment.substatus, 'Goal', f'"{segment.goal}"', robot, segment.queued, segment.completed,
        *(() if echo is None else (echo or '""',)), str(segment.fails))
    return ' '.join(parts)
