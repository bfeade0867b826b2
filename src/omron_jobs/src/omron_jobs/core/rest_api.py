"""Answers requests of REST clients: the part about jobs of FLOW Core's Integration Toolkit; no I/O.

The answer to a request is a status and JSON. The answer to a wrong request, even if its body is no
JSON, is an error record that names the error. A job is made or changed only if the answer is 201.
"""
from __future__ import annotations

import re
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence
from urllib.parse import unquote

from omron_jobs.core.job_book import JobBook, JobGoal, JobRefused
from omron_jobs.core.job_commands import (
    CANCELLABLE,
    DEFAULT_PRIORITIES,
    MOST_GOALS,
    JobCommands,
    JobSite,
    changes_of,
    matching,
    of_other_goal,
    of_other_priority,
)
from omron_jobs.core.job_words import SegmentKind
from omron_jobs.core.jobs import JobOrigin, Place, QueuedJob, SegmentChange
from omron_jobs.core.rest_fields import Fields, WrongRequest, read_object
from omron_jobs.core.rest_records import Record, RestRecords, job_key, updated
from omron_jobs.core.rest_words import (
    AUDITED,
    BY,
    BY_KEY,
    DONE,
    FILTERS,
    HISTORY,
    KEY,
    LATEST,
    NOT_OFFERED,
    REQUESTS,
    SEGMENT_TYPE,
    SHORT_CANCELS,
    SINCE,
    STREAM,
    UPDATED_SINCE,
    WITH_HISTORY,
    CancelType,
    RestType,
)

OK, CREATED, BAD, UNKNOWN, BROKEN = 200, 201, 400, 404, 500
_ERRORS = {BAD: 'Bad Request', UNKNOWN: 'Not Found', BROKEN: 'Internal Server Error'}
_SERVER_FIELDS = ('status', 'assignedJobId', 'audit', 'upd')  # allowed in a posted record
_MILLIS = re.compile(r'\d{1,19}\Z', re.ASCII)
_TYPES = {kind.value: kind for kind in RestType}
_KINDS = {name: kind for kind, word in SEGMENT_TYPE.items()
          for name in (word.lower(), word[0].lower())}
Announce = Callable[[Sequence[SegmentChange]], None]


class RestAnswer(NamedTuple):
    """An answer: its HTTP status, and the value that is sent as JSON."""

    status: int
    body: Any


def error(status: int, message: str) -> RestAnswer:
    """Returns the answer to a request that is not carried out."""
    return RestAnswer(status, {'status': status, 'error': _ERRORS.get(status, 'Error'),
                               'message': message})


def stream_of(path: str) -> Optional[RestType]:
    """Returns the type of the records that are streamed at a path; None: none are streamed."""
    name, _, rest = path.strip('/').partition('/')
    kind = _TYPES.get(name)
    return kind if rest == STREAM and kind is not RestType.STORE_VALUE else None


class RestApi:
    """Answers requests. `announce`: sends changes to all clients of both interfaces."""

    def __init__(self, book: JobBook, site: JobSite, records: RestRecords, announce: Announce
                 ) -> None:
        self._book, self._site, self._records = book, site, records
        self._announce = announce
        self._values = JobCommands(book, site)

    def answer(self, method: str, path: str, query: Mapping[str, str], body: bytes) -> RestAnswer:
        """Answers a request. `path`: as sent, without the query."""
        parts = [unquote(one) for one in path.strip('/').split('/')]
        try:
            reason = NOT_OFFERED.get(parts[0])
            if reason is not None:
                raise WrongRequest(f'{parts[0]} is not offered: {reason}.', UNKNOWN)
            if method == 'GET':
                return self._get(parts, query)
            if method == 'POST' and len(parts) == 1 and _TYPES.get(parts[0]) in AUDITED:
                return RestAnswer(CREATED, self._post(_TYPES[parts[0]], read_object(body)))
            raise WrongRequest('There is no such path with this method.', UNKNOWN)
        except WrongRequest as wrong:
            return error(wrong.status, str(wrong))
        except JobRefused as refused:
            return error(BROKEN if self._site.goals is None else BAD, f'The request {refused}.')
        except OSError as broken:
            return error(BROKEN, f'Jobs cannot be stored ({broken.strerror or broken}): nothing '
                                 'is done.')

    # -- reading ---------------------------------------------------------------------------------

    def _get(self, parts: Sequence[str], query: Mapping[str, str]) -> RestAnswer:
        self._records.put_values(self._values.groups())
        if parts[0] == LATEST and len(parts) == 2:
            return RestAnswer(OK, self._latest(parts[1]))
        kind, how = _TYPES.get(parts[0]), parts[1] if len(parts) > 1 else ''
        if kind is None or len(parts) > 3:
            raise WrongRequest('There is no such path.', UNKNOWN)
        if len(parts) == 2:
            return RestAnswer(OK, self._since(kind, how, query))
        field = how[len(BY):len(BY) + 1].lower() + how[len(BY) + 1:]
        if how == BY_KEY:
            record = self._records.by_key(kind, parts[2])
            if record is None:
                raise WrongRequest(f'There is no {kind.value} with this namekey.', UNKNOWN)
            return RestAnswer(OK, record)
        if len(parts) < 3 or not how.startswith(BY) or field not in FILTERS[kind]:
            raise WrongRequest('There is no such path.', UNKNOWN)
        wanted = parts[2].lower()
        return RestAnswer(OK, [one for one in self._records.of(kind)
                               if _written(one[field]) == wanted])

    def _since(self, kind: RestType, how: str, query: Mapping[str, str]) -> List[Record]:
        text = query.get(SINCE, '0')
        if how == UPDATED_SINCE:
            found = self._records.of(kind)
        elif how == HISTORY and kind in WITH_HISTORY:
            key = query.get(KEY)
            found = [one for one in self._records.history(kind) if key in (None, one['namekey'])]
        else:
            raise WrongRequest('There is no such path.', UNKNOWN)
        if not _MILLIS.match(text):
            raise WrongRequest(f'{SINCE} must be a number of milliseconds since 1970.')
        return [one for one in found if updated(kind, one) >= int(text)]

    def _latest(self, name: str) -> List[Record]:
        item = name.partition(':')[0]
        return [one for one in self._records.of(RestType.STORE_VALUE) if one['namekey'] == item]

    # -- posting ---------------------------------------------------------------------------------

    def _post(self, kind: RestType, found: Dict[str, Any]) -> Record:
        if kind in REQUESTS:
            return self._queue(kind, found)
        if kind is RestType.JOB_CANCEL:
            return self._cancel(found)
        return self._modify(found)

    def _new_key(self, kind: RestType, fields: Fields) -> str:
        key = fields.word('namekey')
        if key.startswith('~') or '/' in key:
            raise WrongRequest('namekey must not begin with ~, and must have no slash.')
        if key and self._records.by_key(kind, key) is not None:
            raise WrongRequest(f'There is already a {kind.value} with this namekey.')
        return key

    def _queue(self, kind: RestType, found: Dict[str, Any]) -> Record:
        fields = Fields(found, 'namekey', 'jobId', *_FIELDS[kind], *_SERVER_FIELDS)
        key, job_id = self._new_key(kind, fields), fields.word('jobId')
        robot, uses_defaults = '', False
        swap: Optional[QueuedJob] = None
        if kind is RestType.JOB_REQUEST:
            uses_defaults = fields.flag('defaultPriority')
            goals = [goal for one in fields.items('details')
                     for goal in self._goals_of(one, uses_defaults)]
        elif kind is RestType.PICKUP_DROPOFF:
            goals = [self._goal(SegmentKind.PICKUP, fields, 'pickupGoal', 'pickupPriority'),
                     self._goal(SegmentKind.DROPOFF, fields, 'dropoffGoal', 'dropoffPriority')]
            swap = self._book.swap_at(goals[0].vertex)
        elif kind is RestType.PICKUP:
            goals = [self._goal(SegmentKind.PICKUP, fields, 'goal', 'priority')]
        else:
            robot = fields.needed('robot')
            if robot not in self._site.robots:
                raise WrongRequest('There is no such robot.')
            goals = [self._goal(SegmentKind.DROPOFF, fields, 'goal', 'priority')]
        if len(goals) > MOST_GOALS:
            raise WrongRequest(f'A job has at most {MOST_GOALS} goals.')
        job = self._book.queue(goals, job_id, robot,
                               JobOrigin(kind.value, key, job_id, uses_defaults), swap)
        self._announce(changes_of(job))
        record = self._records.by_key(kind, key or f'~{job.segments[0].number}')
        assert record is not None  # `_announce` has made it
        return record

    def _goals_of(self, detail: Any, uses_defaults: bool) -> List[JobGoal]:
        """Returns the goals of a detail, in one of its two forms."""
        fields = Fields(detail, 'goal', 'segmentType', 'pickupGoal', 'dropoffGoal', 'priority')
        priority = '' if uses_defaults else 'priority'
        fields.number('priority')
        if 'goal' in fields or 'segmentType' in fields:
            if 'pickupGoal' in fields or 'dropoffGoal' in fields:
                raise WrongRequest('A detail has either goal and segmentType, or pickupGoal and '
                                   'dropoffGoal.')
            kind = _KINDS.get(fields.needed('segmentType').lower())
            if kind is None:
                raise WrongRequest('segmentType must be Pickup or Dropoff.')
            return [self._goal(kind, fields, 'goal', priority)]
        found = [self._goal(kind, fields, name, priority) for kind, name in (
            (SegmentKind.PICKUP, 'pickupGoal'), (SegmentKind.DROPOFF, 'dropoffGoal'))
            if name in fields]
        if not found:
            raise WrongRequest('A detail has no goal.')
        return found

    def _goal(self, kind: SegmentKind, fields: Fields, goal: str, priority: str) -> JobGoal:
        given = fields.number(priority) if priority else None
        return JobGoal(kind, *self._place(fields.needed(goal)),
                       DEFAULT_PRIORITIES[kind] if given is None else given)

    def _place(self, name: str) -> Place:
        vertex = self._site.vertex_of(name)
        if vertex is None:
            raise WrongRequest(f'There is no goal "{name}".')
        return Place(name, vertex)

    def _cancel(self, found: Dict[str, Any]) -> Record:
        fields = Fields(found, 'namekey', 'cancelType', 'cancelValue', 'cancelReason',
                        *SHORT_CANCELS, *_SERVER_FIELDS)
        key, reason = self._new_key(RestType.JOB_CANCEL, fields), fields.reason('cancelReason')
        given = [name for name in ('cancelType', *SHORT_CANCELS) if name in fields]
        if len(given) != 1:
            raise WrongRequest('Name what is to be cancelled in one way: cancelType and '
                               f'cancelValue, or one of {", ".join(SHORT_CANCELS)}.')
        if given[0] == 'cancelType':
            kind = _CANCEL_TYPES.get(fields.needed('cancelType').lower())
            value = fields.needed('cancelValue')
        else:
            kind, value = SHORT_CANCELS[given[0]], fields.needed(given[0])
        if kind is None:
            raise WrongRequest(f'cancelType must be one of {", ".join(_CANCEL_NAMES)}.')
        jobs = self._to_cancel(kind, value)
        if not jobs and kind not in (CancelType.ROBOT_NAME, CancelType.STATUS):
            raise WrongRequest(f'No active job has this {kind.value}.', UNKNOWN)
        posted = self._records.to_post(RestType.JOB_CANCEL, key, {
            'cancelType': kind.value, 'cancelValue': value, 'cancelReason': reason or None,
            'status': DONE})
        self._announce(self._book.cancel(jobs, reason, posted))
        return self._records.post(posted)

    def _to_cancel(self, kind: CancelType, value: str) -> List[QueuedJob]:
        if kind is CancelType.JOB_NAMEKEY:
            return [job for job in self._book.jobs if job.is_open and job_key(job) == value]
        if kind is CancelType.STATUS and value.lower() not in {
                one.value.lower() for one in CANCELLABLE}:
            raise WrongRequest('cancelValue must be Pending, InProgress or Interrupted.')
        return self._book.find(matching(_MATCHED_BY[kind], value, only_current=True),
                               only_open=True)

    def _modify(self, found: Dict[str, Any]) -> Record:
        fields = Fields(found, 'namekey', 'segmentId', 'segmentNamekey', 'priority', 'goal',
                        *_SERVER_FIELDS)
        key = self._new_key(RestType.JOB_SEGMENT_MODIFY, fields)
        id = fields.text('segmentId') or fields.needed('segmentNamekey')
        priority, goal = fields.number('priority'), fields.text('goal')
        if (priority is None) == (not goal):
            raise WrongRequest('Give either a priority or a goal.')
        if not any(one.id.lower() == id.lower() for job in self._book.jobs for one in job.segments):
            raise WrongRequest('There is no such segment.', UNKNOWN)
        place = self._place(goal) if goal else None
        job, one = (of_other_priority if place is None else of_other_goal)(self._book, id)
        posted = self._records.to_post(RestType.JOB_SEGMENT_MODIFY, key, {
            'segmentId': one.id, 'segmentNamekey': one.id, 'priority': priority,
            'goal': goal or None, 'status': DONE})
        if place is not None:
            changes = self._book.set_goal(job, one, place, posted)
        else:
            assert priority is not None
            changes = self._book.set_priority(job, one, priority, posted)
        self._announce(changes)
        return self._records.post(posted)


def _written(value: object) -> str:
    """Returns the value of a field as it is written in a path, in lower case."""
    return '' if value is None else str(value).lower()


_FIELDS: Mapping[RestType, Sequence[str]] = {
    RestType.JOB_REQUEST: ('defaultPriority', 'details'),
    RestType.PICKUP: ('goal', 'priority'),
    RestType.DROPOFF: ('robot', 'goal', 'priority'),
    RestType.PICKUP_DROPOFF: ('pickupGoal', 'pickupPriority', 'dropoffGoal', 'dropoffPriority')}
_CANCEL_NAMES = [kind.value for kind in CancelType]
_CANCEL_TYPES = {kind.value.lower(): kind for kind in CancelType}
_MATCHED_BY: Mapping[CancelType, str] = {
    CancelType.SEGMENT_ID: 'id', CancelType.SEGMENT_NAMEKEY: 'id',
    CancelType.REMOVE_SEGMENT_ID: 'id', CancelType.REMOVE_SEGMENT_NAMEKEY: 'id',
    CancelType.JOB_ID: 'jobid', CancelType.ROBOT_NAME: 'robotname', CancelType.STATUS: 'status'}
