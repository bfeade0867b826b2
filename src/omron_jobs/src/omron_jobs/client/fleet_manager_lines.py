"""The lines between a program that gives jobs and OMRON's Fleet Manager, from the program's side.

The server of this package and the simulator have separate tables: a mistake in one table then shows
as a difference between them.
"""
from __future__ import annotations

import re
from dataclasses import dataclass
from typing import List, Optional, Union

from omron_jobs.client.handed_jobs import Change, HandedJob, HandedSegment, HandedStopKind

QUERY = 'queuequery'
MODIFY = 'queuemodify'
MOST_STOPS = 50
_LONGEST_NAME = 127
_WORD = re.compile(r'"[^"]*"|\S+')
_LINKED = re.compile(r'and linked to job_id (\S+)')
_MODIFYING = ('modifying', 'modiying')  # a published client expects the second spelling
_SEGMENT_LINES = ('queueupdate:', 'queuequery:', 'queueshow:')


class WrongJob(ValueError):
    """A job that no command can express. The text is a clause with the reason."""


@dataclass(frozen=True)
class SegmentLine:
    """A line about a segment of a job. `is_listed`: it belongs to the answer to a query."""

    segment: HandedSegment
    job: str
    robot: str
    is_listed: bool


@dataclass(frozen=True)
class AnswerEnd:
    """The last line of the answer to a command; `command` in lower case.

    linked -- for a swap: id of the job that drops off where the new job picks up; empty: no swap
    """

    command: str
    linked: str = ''


@dataclass(frozen=True)
class ErrorBegin:
    """The first line of an error: it names the command, in lower case."""

    command: str


@dataclass(frozen=True)
class ErrorText:
    """The last line of an error. `is_whole`: it is also the first line."""

    text: str
    is_whole: bool


FleetManagerLine = Union[SegmentLine, AnswerEnd, ErrorBegin, ErrorText]


def command_of(job: HandedJob) -> str:
    """Returns the command that hands a job over."""
    stops = job.stops
    priorities = ['default' if stop.priority is None else str(stop.priority) for stop in stops]
    goals = [_quoted(stop.goal) for stop in stops]
    if len(stops) == 1:
        return f'queuePickup {goals[0]} {priorities[0]} {job.id}'
    if [stop.kind for stop in stops] == [HandedStopKind.PICKUP, HandedStopKind.DROPOFF]:
        return f'queuePickupDropoff {" ".join(goals)} {" ".join(priorities)} {job.id}'
    fields = ' '.join(f'{goal} {stop.kind.value} {priority}'
                      for goal, stop, priority in zip(goals, stops, priorities))
    return f'queueMulti {len(stops)} 2 {fields} {job.id}'


def query_of(job: HandedJob) -> str:
    """Returns the query for the segments of a job and their states. An unknown job has none."""
    return f'queueQuery jobId {job.id}'


def cancellation_of(job: HandedJob) -> str:
    """Returns the command that cancels a job."""
    return f'queueCancel jobId {job.id}'


def modification_of(change: Change) -> str:
    """Returns the command that changes one value of a segment."""
    return f'queueModify {change.segment.id} {change.field} {_quoted(change.value)}'


def check(job: HandedJob) -> None:
    """Raises WrongJob for a job that the Fleet Manager does not accept."""
    if not 0 < len(job.stops) <= MOST_STOPS:
        raise WrongJob(f'it has {len(job.stops)} goals, not 1 to {MOST_STOPS}')
    if job.stops[0].kind is not HandedStopKind.PICKUP:
        raise WrongJob('its first goal is no pickup')
    for stop in job.stops:
        if not stop.goal or len(stop.goal) > _LONGEST_NAME or '"' in stop.goal \
                or not stop.goal.isascii() or not stop.goal.isprintable():
            raise WrongJob(f'{stop.goal!r} can be no name of a goal')


def read_line(text: str) -> Optional[FleetManagerLine]:
    """Returns the meaning of a line; None: the line is not about jobs."""
    words = _WORD.findall(text)
    if not words:
        return None
    first = words[0].lower()
    if first in _SEGMENT_LINES:
        return _read_segment(words)
    if first in ('endqueuequery', 'endqueuemulti'):
        return AnswerEnd(first[3:])
    if first in ('queuepickup', 'queuepickupdropoff') and 'successfully queued' in text:
        linked = _LINKED.search(text)
        return AnswerEnd(first, linked.group(1) if linked else '')
    if first == MODIFY and len(words) > 1 and words[1].lower() in _MODIFYING:
        return AnswerEnd(first)
    if first == 'commanderror:':
        return ErrorBegin(words[1].lower() if len(words) > 1 else '')
    if first == 'commanderrordescription:':
        return ErrorText(text.partition(':')[2].strip(), False)
    if first == 'setuperror:' or text.startswith('Unknown command'):
        return ErrorText(text.strip(), True)
    return None


def _read_segment(words: List[str]) -> Optional[SegmentLine]:
    if len(words) < 9:
        return None
    try:
        priority = int(words[3])
    except ValueError:
        return None
    robot = words[8].strip('"')
    segment = HandedSegment(words[1], words[4], words[7].strip('"'), priority)
    return SegmentLine(segment, words[2], '' if robot.lower() == 'none' else robot,
                       words[0].lower() == 'queuequery:')


def _quoted(name: str) -> str:
    return f'"{name}"' if ' ' in name else name
