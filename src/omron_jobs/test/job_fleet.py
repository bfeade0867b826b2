"""A fleet manager for tests of the job server, and a disk that can fail.

It follows docs/reference/path_supervisor.md: it recognises a repeat by id and stamp, shows a
mission after each change, and answers questions from its journal.
"""
from __future__ import annotations

from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

from omron_jobs.core.job_book import FleetAct, FleetMessage, JobBook, JobCounters
from omron_jobs.core.jobs import JobDrive, JobMission, JobMissionState, QueuedJob, SegmentChange
from omron_jobs.core.posted_records import PostedRecord

Key = Tuple[int, int]


class Disk:
    """Keeps jobs. While `is_full`, nothing is stored."""

    def __init__(self) -> None:
        self.jobs: Dict[int, QueuedJob] = {}
        self.counters = JobCounters()
        self.posted: List[PostedRecord] = []
        self.is_full = False

    def write(self, jobs: Sequence[QueuedJob], forgotten: Sequence[int],
              counters: JobCounters, posted: Optional[PostedRecord] = None) -> None:
        if self.is_full:
            raise OSError(28, 'No space left on device')
        self.jobs.update((job.mission, job) for job in jobs)
        for id in forgotten:
            del self.jobs[id]
        self.counters = counters
        if posted is not None:
            self.posted.append(posted)


class Mission(NamedTuple):
    """A mission as the fleet manager has it."""

    stops: int
    shown: JobMission


class FakeFleet:
    """Accepts missions. All other events happen when a test calls a method.

    driven -- the stops at which a robot has been, each as (mission, number of the stop)
    """

    def __init__(self) -> None:
        self.missions: Dict[Key, Mission] = {}
        self.driven: List[Tuple[Key, int]] = []
        self.refuses = self.refuses_changes = False

    def handle(self, message: FleetMessage) -> Iterator[Tuple[Key, Optional[JobMission]]]:
        """Handles a message. Yields the missions that it shows; None: the mission is unknown."""
        key = message.job.mission, message.job.queued
        if message.act is FleetAct.REQUEST and key not in self.missions:
            self.missions[key] = Mission(
                len(message.job.segments), JobMission(
                    JobMissionState.REFUSED if self.refuses else JobMissionState.PENDING,
                    priority=message.job.segments[0].priority, places=places_of(message.job)))
        mission = self.missions.get(key)
        if mission is None:
            if message.act is FleetAct.ASK:
                yield key, None
            return
        if message.act is FleetAct.CANCEL and mission.shown.state.is_open:
            self.set(key, JobMissionState.CANCELLED)
        if message.act is FleetAct.CHANGE and mission.shown.state.is_open:
            if self.refuses_changes or message.first and message.first <= mission.shown.reached:
                yield key, mission.shown._replace(is_refusal=True)
                return
            kept = message.first - 1 if message.first else mission.stops
            self.missions[key] = mission._replace(shown=mission.shown._replace(
                priority=message.job.segments[0].priority,
                places=(*mission.shown.places[:kept], *places_of(message.job)[kept:])))
        yield key, self.missions[key].shown

    def set(self, key: Key, state: JobMissionState, robot: Optional[str] = None) -> None:
        mission = self.missions[key]
        shown = mission.shown._replace(state=state)
        self.missions[key] = mission._replace(
            shown=shown if robot is None else shown._replace(robot=robot))

    def drives(self) -> Dict[int, JobDrive]:
        """The drives of the robots of all active missions."""
        return {key[0]: JobDrive(one.shown.robot, one.shown.places[one.shown.reached])
                for key, one in self.missions.items()
                if one.shown.state is JobMissionState.ACTIVE and one.shown.robot}

    def reach(self, key: Key) -> None:
        """Lets the robot of an active mission complete its next stop."""
        mission = self.missions[key]
        self.driven.append((key, mission.shown.reached))
        reached = mission.shown.reached + 1
        state = mission.shown.state if reached < mission.stops else JobMissionState.SUCCEEDED
        self.missions[key] = mission._replace(shown=mission.shown._replace(
            state=state, reached=reached))


def places_of(job: QueuedJob) -> Tuple[int, ...]:
    return tuple(one.vertex for one in job.segments)


def tell(book: JobBook, key: Key, shown: Optional[JobMission], now: float) -> List[SegmentChange]:
    """Gives a job book a message of the fleet manager."""
    if shown is None:
        return book.hear_unknown(*key, asked=now)
    return book.hear(*key, shown, now)
