"""The records of the REST server, derived from the job book and the site: no I/O.

Each record is derived from a job, a robot or a goal. This module also keeps the time of the last
change of each record, and its former versions (`History`). After a restart each record of an open
job counts as changed, so that no client misses a change; the history begins anew. Cancellations and
modifications are not derived: they are stored as they were posted.
"""
from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Any, Callable, Deque, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

from omron_jobs.core.job_book import JobBook
from omron_jobs.core.job_commands import JobSite
from omron_jobs.core.job_words import NONE, SegmentStatus
from omron_jobs.core.jobs import JobSegment, QueuedJob, SegmentChange
from omron_jobs.core.posted_records import MOST_POSTED, PostedRecord
from omron_jobs.core.rest_words import (
    AUDITED,
    BEING_MODIFIED,
    FAILED,
    JOB_TYPE,
    MULTI,
    ROBOT_STATUS,
    SEGMENT_STATUS,
    SEGMENT_TYPE,
    WITH_HISTORY,
    JobStatus,
    RestType,
)
from omron_jobs.core.robots import RobotFault, RobotNews, faults_of

LONGEST_HISTORY = 5000  # largest number of kept versions for each type of records
Record = Dict[str, Any]
Listener = Callable[[RestType, Record], None]
_REFUSED = (SegmentStatus.CANCELLED, SegmentStatus.CANCELLING)


def moment(milliseconds: int) -> Optional[Dict[str, int]]:
    """Returns a moment (ms since 1970) in the form of the records; None for 0."""
    return {'millis': milliseconds} if milliseconds else None


def job_key(job: QueuedJob) -> str:
    """Returns the namekey of a job. It is unique for ever, while a job id may be used again."""
    return _key(job.segments[0].number)


def _key(number: int) -> str:
    return f'JOB{number}'


def request_key(job: QueuedJob) -> str:
    """Returns the namekey of the request for a job."""
    key = job.origin.key if job.origin is not None else ''
    return key or f'~{job.segments[0].number}'


def status_of(job: QueuedJob) -> JobStatus:
    """Returns the status of a job, which follows from the statuses of its segments."""
    statuses = [one.told.status for one in job.segments]
    if any(one in BEING_MODIFIED for one in statuses):
        return JobStatus.MODIFYING
    if all(one is SegmentStatus.COMPLETED for one in statuses):
        return JobStatus.COMPLETED
    if statuses[-1].is_final:
        return JobStatus.CANCELLED
    if any(one in _REFUSED for one in statuses) or job.cancel is not None:
        return JobStatus.CANCELLING
    return (JobStatus.PENDING if all(one is SegmentStatus.PENDING for one in statuses)
            else JobStatus.IN_PROGRESS)


def job_record(job: QueuedJob) -> Record:
    """Returns the record of a job, without its time."""
    robots = [one.told.robot for one in job.segments if one.told.robot]
    statuses = [one.told.status for one in job.segments]
    return {
        'namekey': job_key(job), 'jobId': job.id,
        'jobType': JOB_TYPE.get(tuple(one.kind for one in job.segments), MULTI),
        'queuedTimestamp': moment(job.queued),
        'completedTimestamp': moment(job.segments[-1].ended), 'status': status_of(job).value,
        'linkedJob': _key(job.swap) if job.swap else None, 'failCount': 0,
        'lastAssignedRobot': robots[-1] if robots else '',
        'cancelReason': FAILED if SegmentStatus.FAILED in statuses else _reason(job.segments[-1])
        or job.cancel or None}


def _reason(segment: JobSegment) -> Optional[str]:
    told = segment.told
    return told.substatus if told.status in _REFUSED and told.substatus != NONE else None


def segment_record(job: QueuedJob, segment: JobSegment) -> Record:
    """Returns the record of a segment of a job, without its time."""
    index = next(k for k, one in enumerate(job.segments) if one.number == segment.number)
    return {
        'namekey': segment.id, 'seq': index + 1, 'segmentId': segment.id,
        'segmentType': SEGMENT_TYPE[segment.kind], 'status': SEGMENT_STATUS[segment.told.status],
        'subStatus': segment.told.substatus, 'job': job_key(job),
        'robot': segment.told.robot or None,
        'linkedJobSegment': job.segments[index - 1].id if index else None,
        'goalName': segment.goal, 'priority': segment.priority,
        'completedTimestamp': moment(segment.ended), 'cancelReason': _reason(segment)}


def request_record(job: QueuedJob) -> Record:
    """Returns the record of the REST request for a job, without its time."""
    assert job.origin is not None
    record: Record = {'namekey': request_key(job), 'jobId': job.origin.job_id}
    first, last = job.segments[0], job.segments[-1]
    kind = RestType(job.origin.kind)
    if kind is RestType.JOB_REQUEST:
        record.update(defaultPriority=job.origin.default_priority, details=[
            {'goal': one.goal, 'priority': one.priority, 'segmentType': SEGMENT_TYPE[one.kind]}
            for one in job.segments])
    elif kind is RestType.PICKUP_DROPOFF:
        record.update(pickupGoal=first.goal, pickupPriority=first.priority, dropoffGoal=last.goal,
                      dropoffPriority=last.priority)
    else:
        record.update(goal=first.goal, priority=first.priority)
        if kind is RestType.DROPOFF:
            record['robot'] = job.robot
    record.update(status=status_of(job).value, assignedJobId=job.id)
    return record


def robot_record(name: str, robot: RobotNews) -> Record:
    """Returns the record of a robot, without its time."""
    return {'namekey': name, 'status': ROBOT_STATUS[robot.status], 'subStatus': robot.substatus}


def fault_record(fault: RobotFault) -> Record:
    """Returns the record of a fault that a robot has, without its time."""
    return {
        'namekey': f'{fault.robot}:{fault.name}', 'robot': fault.robot, 'active': True,
        'driving': True, 'critical': False, 'clearedOnGo': False, 'clearedOnAck': False,
        'application': fault.is_application, 'name': fault.name, 'type': fault.type,
        'shortDescription': fault.name, 'longDescription': fault.text}


def updated(kind: RestType, record: Mapping[str, Any]) -> int:
    """Returns when a record changed last, in ms since 1970."""
    stamp = record['audit']['upd'] if kind in AUDITED else record['upd']
    return int(stamp['millis'])


class RestRecords:
    """All records, each with the time of its last change.

    Its attributes are the records of each type, with their numbers and times.
    clock -- returns ms since 1970
    posted -- the stored records of cancellations and modifications
    listeners -- called with each record that is new or has changed
    """

    def __init__(self, book: JobBook, site: JobSite, clock: Callable[[], int],
                 posted: Iterable[PostedRecord] = ()) -> None:
        self.listeners: List[Listener] = []
        self._book, self._site, self._clock = book, site, clock
        self._tables: Dict[RestType, Dict[str, Record]] = {kind: {} for kind in RestType}
        self._history: Dict[RestType, Deque[Record]] = {
            kind: deque(maxlen=LONGEST_HISTORY) for kind in WITH_HISTORY}
        self._shown: Dict[int, QueuedJob] = {}
        self._changed: Dict[int, None] = {}     # missions of changed jobs, in order
        self._by_segment: Dict[int, int] = {}
        self._robots: Mapping[str, RobotNews] = {}
        self._goals: Optional[Mapping[str, int]] = None
        self._numbers: Dict[RestType, int] = {}     # number of the newest posted record
        self._last = 0
        for one in posted:
            self.post(one)
        for job in book.jobs:  # at the start, only open jobs count as changed
            if job.is_open:
                self._changed[job.mission] = None
            else:
                self._show_job(job, job.segments[-1].ended)
        book.shelf.on_change = self._note
        self.refresh()

    # -- queries ---------------------------------------------------------------------------------

    def of(self, kind: RestType) -> Sequence[Record]:
        """Returns all records of a type, the oldest first."""
        return list(self._tables[kind].values())

    def by_key(self, kind: RestType, key: str) -> Optional[Record]:
        """Returns the record with a key."""
        return self._tables[kind].get(key)

    def history(self, kind: RestType) -> Sequence[Record]:
        """Returns all kept versions of all records of a type, in order."""
        return list(self._history[kind])

    # -- changes ---------------------------------------------------------------------------------

    def to_post(self, kind: RestType, key: str, record: Record) -> PostedRecord:
        """Returns a cancellation or modification, to be stored with the jobs that it changes.

        key -- empty: the client gave none
        """
        number = self._numbers.get(kind, 0) + 1
        return PostedRecord(kind.value, number, self._now(),
                            {'namekey': key or f'~{number}', **record})

    def post(self, posted: PostedRecord) -> Record:
        """Keeps a cancellation or modification that was carried out, and returns its record."""
        kind = RestType(posted.kind)
        table = self._tables[kind]
        while len(table) >= MOST_POSTED:
            del table[next(iter(table))]
        self._numbers[kind] = posted.number
        return self._put(kind, dict(posted.record), posted.at)

    def put_values(self, groups: Mapping[str, Mapping[str, object]]) -> None:
        """Updates the values of the data store, by group and item."""
        for group, items in groups.items():
            for item, value in items.items():
                self._put(RestType.STORE_ITEM, {
                    'namekey': item, 'groupName': group, 'itemName': item, 'displayName': item})
                self._put(RestType.STORE_VALUE, {'namekey': item, 'value': str(value)})

    def announce(self, changes: Iterable[SegmentChange]) -> None:
        """Updates the records of these changed segments, in order, and then calls `refresh`."""
        self._find_new_jobs()
        for change in changes:
            job = self._shown.get(self._by_segment.get(change.segment.number, 0))
            if job is not None:
                self._show_job(replace(job, segments=tuple(
                    change.segment if one.number == change.segment.number else one
                    for one in job.segments)))
        self.refresh()

    def _note(self, mission: int) -> None:
        self._changed[mission] = None

    def _find_new_jobs(self) -> None:
        for mission in self._changed:
            job = self._book.shelf.get(mission)
            if job is not None and mission not in self._shown:
                self._show_job(job)

    def refresh(self) -> None:
        """Updates the records of jobs, robots and goals."""
        changed, self._changed = self._changed, {}
        for mission in changed:
            job, shown = self._book.shelf.get(mission), self._shown.get(mission)
            if job is None and shown is not None:
                del self._shown[mission]
                self._forget_job(shown)
            elif job is not None and job is not shown:
                self._show_job(job)
        self._show_robots()
        if self._site.goals is not None and self._site.goals is not self._goals:
            self._goals = self._site.goals
            for name in [one for one in self._tables[RestType.GOAL] if one not in self._goals]:
                del self._tables[RestType.GOAL][name]
            for name in self._goals:
                self._put(RestType.GOAL, {'namekey': name})

    def _show_job(self, job: QueuedJob, at: int = 0) -> None:
        self._shown[job.mission] = job
        for segment in job.segments:
            self._by_segment[segment.number] = job.mission
            self._put(RestType.JOB_SEGMENT, segment_record(job, segment), at)
        self._put(RestType.JOB, job_record(job), at)
        if job.origin is not None:
            self._put(RestType(job.origin.kind), request_record(job), at)

    def _forget_job(self, job: QueuedJob) -> None:
        keys: List[Tuple[RestType, str]] = [(RestType.JOB, job_key(job))]
        for segment in job.segments:
            del self._by_segment[segment.number]
            keys.append((RestType.JOB_SEGMENT, segment.id))
        if job.origin is not None:
            keys.append((RestType(job.origin.kind), request_key(job)))
        for kind, key in keys:
            self._tables[kind].pop(key, None)

    def _show_robots(self) -> None:
        robots = self._site.robots
        if robots is self._robots:
            return
        self._robots = robots
        for name in [one for one in self._tables[RestType.ROBOT] if one not in robots]:
            del self._tables[RestType.ROBOT][name]
        for name, robot in robots.items():
            self._put(RestType.ROBOT, robot_record(name, robot))
        active = {one['namekey']: one for one in map(fault_record, faults_of(robots))}
        for record in active.values():
            self._put(RestType.ROBOT_FAULT, record)
        for record in self.of(RestType.ROBOT_FAULT):
            if record['active'] and record['namekey'] not in active:
                ended = {name: value for name, value in record.items() if name != 'upd'}
                self._put(RestType.ROBOT_FAULT, {**ended, 'active': False})

    def _now(self) -> int:
        """Returns the time of a change. It never goes back, so `UpdatedSince` misses no change."""
        return max(self._last, self._clock())

    def _put(self, kind: RestType, content: Record, at: int = 0) -> Record:
        """Keeps a record if it has changed. `at`: time of the change; 0: now."""
        table, key = self._tables[kind], content['namekey']
        before = table.get(key)
        if before is not None and all(before[name] == value for name, value in content.items()):
            return before
        at = at or self._now()
        self._last = max(self._last, at)
        stamp = {'millis': at}
        record = dict(content)
        if kind in AUDITED:
            created = before['audit']['crt'] if before is not None else stamp
            record['audit'] = {'crt': created, 'upd': stamp}
        else:
            record['upd'] = stamp
        table[key] = record
        if kind in self._history:
            self._history[kind].append(record)
        for listener in list(self.listeners):
            listener(kind, record)
        return record
