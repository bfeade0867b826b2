"""All jobs: accepts, changes and cancels them, and follows their missions.

A job is stored before its client gets the reply that it is queued. The request for its mission is
repeated, with the same id and stamp, until the fleet manager has shown the mission. The fleet
manager recognises repeats by id and stamp. So neither a lost message nor a restart of either side
loses a job, or makes it run twice.
A cancellation is stored and repeated in the same way, until the mission ends. A change of priority
or goal is stored and repeated until the mission shows it, or the fleet manager refuses the goal.
The status of a mission is sent to clients at once, and stored later. If it cannot be stored, it can
be derived from the mission again.
"""
from __future__ import annotations

import math
from dataclasses import replace
from enum import Enum
from typing import (
    Callable,
    Dict,
    Iterable,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Protocol,
    Sequence,
    Set,
)

from omron_jobs.core.job_shelf import JobShelf
from omron_jobs.core.job_words import SegmentKind, SegmentStatus
from omron_jobs.core.jobs import (
    JobDrive,
    JobMission,
    JobMissionState,
    JobOrigin,
    JobSegment,
    Place,
    QueuedJob,
    SegmentChange,
    carrier_to,
    first_misplaced,
    lost,
    news_of,
    queued_segments,
    with_goal,
    with_priority,
)
from omron_jobs.core.posted_records import PostedRecord

REPEAT = 2.0        # s between two messages about one job to the fleet manager
SILENCE = 10.0      # s without news of a mission, after which a question is sent
QUESTIONS = 10      # largest number of questions per second; a thousand missions may be silent
MOST_OPEN = 2000    # largest number of open jobs
MOST_ENDED = 100    # jobs that are kept after their end; OMRON's MaxNumberOfCompletedItems
KEEP_ENDED = 60     # min for which ended jobs are kept; OMRON's DeleteCompletedItemsMinutes


class JobRefused(Exception):
    """A refused command. The text continues a sentence that begins with the command's name."""


class JobCounters(NamedTuple):
    """Counters over all jobs since the file was made.

    number -- the number of the next segment
    """

    number: int = 1
    completed: int = 0
    cancelled: int = 0


class JobStore(Protocol):
    """Keeps jobs on a disk."""

    def write(self, jobs: Sequence[QueuedJob], forgotten: Sequence[int], counters: JobCounters,
              posted: Optional[PostedRecord] = None) -> None:
        """Stores jobs, all or none; replaces stored jobs of the same missions. Raises OSError.

        forgotten -- missions of jobs to be removed
        posted    -- the REST record that has changed the jobs
        """


class JobGoal(NamedTuple):
    """One goal of a job that is to be queued."""

    kind: SegmentKind
    goal: str
    vertex: int
    priority: int


class FleetAct(Enum):
    """The kind of a message to the fleet manager about a job."""

    REQUEST = 'request'
    CANCEL = 'cancel'
    CHANGE = 'change'   # changes priority (of the first segment), stop `first`, all later stops
    ASK = 'ask'         # queries the stored state of its mission


class FleetMessage(NamedTuple):
    """A message to the fleet manager about the mission of a job.

    first -- number, from 1, of the first stop to be changed; 0: no stop is changed
    """

    act: FleetAct
    job: QueuedJob
    first: int = 0


class JobBook:
    """The jobs of one fleet.

    It has many attributes because it keeps several things for each mission: the last status, its
    time, and the time of the last message about the mission.

    jobs, counters -- as they were stored
    shelf -- all jobs that are kept
    clock -- returns ms since 1970
    new_mission -- returns a random id for a request
    """

    def __init__(self, jobs: Iterable[QueuedJob], counters: JobCounters, store: JobStore,
                 clock: Callable[[], int], new_mission: Callable[[], int]) -> None:
        self.shelf = JobShelf(jobs)
        self.counters = counters
        self._store, self._clock, self._new_mission = store, clock, new_mission
        self._news: Dict[int, JobMission] = {}
        self._drives: Mapping[int, JobDrive] = {}
        self._sent: Dict[int, float] = {}
        self._heard: Dict[int, float] = {}
        self._unstored: Set[int] = set()
        self._restless: Set[int] = {job.mission for job in self.shelf.open}
        self._silent_from = -math.inf   # no mission is silent before this moment
        self._asked = -math.inf         # the questions allowed up to this moment are used up

    # -- queries of clients ----------------------------------------------------------------------

    @property
    def jobs(self) -> Sequence[QueuedJob]:
        """All jobs that are kept, the oldest first."""
        return self.shelf.all

    def find(self, matches: Callable[[QueuedJob, JobSegment], bool], only_open: bool = False,
             ) -> List[QueuedJob]:
        """Returns the jobs with a segment that matches, the oldest first."""
        return [job for job in (self.shelf.open if only_open else self.shelf.all)
                if any(matches(job, segment) for segment in job.segments)]

    # -- commands of clients ---------------------------------------------------------------------

    def swap_at(self, vertex: int) -> Optional[QueuedJob]:
        """Returns the oldest job whose robot next drops off at a vertex, and has no other job.

        Returns None if there is no such job.
        """
        running = self.shelf.open
        taken = {'', *(job.robot for job in running)}
        return next((job for job in running if carrier_to(job, vertex) not in taken), None)

    def queue(self, goals: Sequence[JobGoal], id: str = '', robot: str = '',
              origin: Optional[JobOrigin] = None, swap: Optional[QueuedJob] = None) -> QueuedJob:
        """Accepts a job. Raises JobRefused, and OSError if it cannot be stored.

        id     -- given by the client; empty: the job gets an id `JOB...`, as OMRON's jobs do
        robot  -- the robot that must serve it; empty: any robot
        origin -- the REST record that requests it; None: it comes over ARCL
        swap   -- a job whose robot must also serve the new job
        """
        if swap is not None:
            robot = swap.segments[-1].told.robot
        active = self.shelf.open_ids
        if id.lower() in active:
            raise JobRefused(f'job_id "{id}" is the id of an active job')
        if len(active) >= MOST_OPEN:
            raise JobRefused(f'there are {MOST_OPEN} active jobs: cancel some, or wait')
        number = self.counters.number
        while not id and f'job{number}' in active:
            number += 1
        job = QueuedJob(
            id or f'JOB{number}',
            queued_segments(tuple(JobSegment(number + k, *goal) for k, goal in enumerate(goals)),
                            robot),
            self._clock(), self._free_mission(), robot=robot, origin=origin,
            swap=0 if swap is None else swap.segments[0].number)
        counters = self.counters._replace(number=number + len(goals))
        self._store.write([job], (), counters)
        self.shelf.put(job)
        self.counters = counters
        self._restless.add(job.mission)
        return job

    def _free_mission(self) -> int:
        while True:
            mission = self._new_mission()
            if mission not in self.shelf:
                return mission

    def cancel(self, jobs: Sequence[QueuedJob], reason: str,
               posted: Optional[PostedRecord] = None) -> List[SegmentChange]:
        """Cancels jobs that have not ended. Raises OSError if the cancellation cannot be stored.

        posted -- here and below: the REST record that requests the change; both are stored together
        """
        wanted = [replace(job, cancel=reason) for job in jobs if job.cancel is None]
        self._keep(wanted, posted)
        changes: List[SegmentChange] = []
        for job in wanted:
            changes += self._show_again(job)
        return changes

    def _show_again(self, job: QueuedJob) -> List[SegmentChange]:
        news = self._news.get(job.mission)
        if news is None or not job.is_open:
            return []
        return self._show(job, news._replace(is_refusal=False))

    def set_priority(self, job: QueuedJob, segment: JobSegment, priority: int,
                     posted: Optional[PostedRecord] = None) -> List[SegmentChange]:
        """Changes the priority of a segment. Raises OSError if the change cannot be stored."""
        changed, changes = with_priority(job, segment.number, priority)
        self._keep([changed], posted)
        return changes

    def set_goal(self, job: QueuedJob, segment: JobSegment, place: Place,
                 posted: Optional[PostedRecord] = None) -> List[SegmentChange]:
        """Changes the goal of a segment, unless its mission already shows that it is too late.

        Raises JobRefused, and OSError if it cannot be stored.
        """
        if segment.other is not None:
            raise JobRefused(f'failed: "{segment.id}" is just being changed: try again')
        changed, changes = with_goal(job, segment.number, place)
        self._keep([changed], posted)
        return [*changes, *self._show_again(changed)]

    def _keep(self, jobs: Sequence[QueuedJob], posted: Optional[PostedRecord]) -> None:
        self._store.write(jobs, (), self.counters, posted)
        for job in jobs:
            self.shelf.put(job)
            self._restless.add(job.mission)
            if job.is_known:
                self._sent.pop(job.mission, None)

    # -- the fleet manager -----------------------------------------------------------------------

    def due(self, now: float) -> List[FleetMessage]:
        """Returns messages to send now, while the fleet manager listens. `now`: s, monotonic."""
        found = []
        for id in sorted(self._restless):
            job = self.shelf[id]
            act = self._act(job)
            if act is None:
                self._restless.discard(id)
            elif now - self._sent.get(id, -math.inf) >= REPEAT:
                self._sent[id] = now
                first = first_misplaced(job, self._news[id]) if act is FleetAct.CHANGE else None
                found.append(FleetMessage(act, job, 0 if first is None else first + 1))
        return found

    def _act(self, job: QueuedJob) -> Optional[FleetAct]:
        if not job.is_open:
            return None
        if not job.is_known:
            return FleetAct.REQUEST
        news = self._news.get(job.mission)
        if news is None:
            return FleetAct.ASK
        if news.state is JobMissionState.CANCELLING:
            return None
        if job.cancel is not None:
            return FleetAct.CANCEL
        is_other = (news.priority != job.segments[0].priority
                    or first_misplaced(job, news) is not None)
        return FleetAct.CHANGE if is_other else None

    def silent(self, now: float) -> List[FleetMessage]:
        """Returns questions about silent missions, whose status may be lost. `now`: as in `due`."""
        most = int(min(now - self._asked, SILENCE) * QUESTIONS)
        if most < 1 or now < self._silent_from:
            return []
        self._silent_from = now + SILENCE
        silent = []
        for job in self.shelf.open:
            news = self._news.get(job.mission)
            if news is not None:
                last = max(self._heard[job.mission], self._sent.get(job.mission, -math.inf))
                if now - last >= SILENCE:
                    silent.append((news.state is JobMissionState.PENDING, last, job))
                else:
                    self._silent_from = min(self._silent_from, last + SILENCE)
        self._asked = max(self._asked, now - SILENCE) + min(len(silent), most) / QUESTIONS
        if len(silent) > most:  # jobs with a robot come first, then those with the oldest news
            silent.sort(key=lambda one: one[:2])
            self._silent_from = now
        for _, _, job in silent[:most]:
            self._sent[job.mission] = now
        return [FleetMessage(FleetAct.ASK, job) for _, _, job in silent[:most]]

    def hear(self, mission: int, stamp: int, news: JobMission, now: float) -> List[SegmentChange]:
        """Handles the status of a mission. `stamp`: that of its request, ms; `now`: as in `due`."""
        job = self.shelf.get(mission)
        if job is None or job.queued != stamp or not job.is_open:
            return []
        self._news[mission], self._heard[mission] = news, now
        changes = self._show(job, news)
        if self.shelf[mission].is_open:
            self._restless.add(mission)
        return changes

    def hear_drives(self, drives: Mapping[int, JobDrive]) -> List[SegmentChange]:
        """Handles the drives of all robots. The keys are the missions that the robots serve."""
        before, self._drives = self._drives, drives
        return [change for mission, drive in drives.items()
                if mission in self.shelf and before.get(mission) != drive
                for change in self._show_again(self.shelf[mission])]

    def hear_unknown(self, mission: int, stamp: int, asked: float) -> List[SegmentChange]:
        """Notes that the fleet manager does not know a mission that it had accepted.

        asked -- s, monotonic: when the question was sent; a later status refutes the answer
        """
        job = self.shelf.get(mission)
        if job is None or job.queued != stamp or not job.is_open or not job.is_known or (
                self._heard.get(mission, -math.inf) >= asked):
            return []
        return self._show(job, lost(job))

    def _show(self, job: QueuedJob, news: JobMission) -> List[SegmentChange]:
        drive = self._drives.get(job.mission)
        shown, changes = news_of(job, news._replace(drive=drive), self._clock())
        if shown == job:
            return []
        self.shelf.put(shown)
        self._unstored.add(job.mission)
        if not shown.is_open:
            self._restless.discard(job.mission)
            self._count(shown.segments[-1].told.status)
        return changes

    def _count(self, end: SegmentStatus) -> None:
        counters = self.counters
        self.counters = counters._replace(
            completed=counters.completed + (end is SegmentStatus.COMPLETED),
            cancelled=counters.cancelled + (end is SegmentStatus.CANCELLED))

    # -- the disk --------------------------------------------------------------------------------

    def store_news(self) -> None:
        """Stores the news of missions, and forgets old jobs. After an OSError, call it again."""
        forgotten = self.shelf.too_old(self._clock() - KEEP_ENDED * 60_000, MOST_ENDED)
        changed = [self.shelf[id] for id in sorted(self._unstored) if id not in forgotten]
        if changed or forgotten:
            self._store.write(changed, forgotten, self.counters)
        self._unstored.clear()
        for id in forgotten:
            self.shelf.forget(id)
            for table in (self._news, self._sent, self._heard):
                table.pop(id, None)
