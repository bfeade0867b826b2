"""Judges whether the lines that a program got about its jobs follow OMRON's order, and are true.

It reads the lines of the job server with a separate table, and has the true positions of the
robots. It does not use the job server's book. Each error that it finds is a sentence. It checks:

    ORDER   a segment passes states in OMRON's order; nothing is sent after a final state
    CHAIN   a segment begins only after the one before it is completed
    LOST    each job that was queued has ended at the end of the day
    TWICE   a job is one mission of the fleet manager
    TRUE    a segment is completed only if its robot was at its goal after the segment began; a job
            ends in the state of its mission, and is cancelled only if a program cancelled it
"""
from __future__ import annotations

import math
import re
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Dict, FrozenSet, List, Mapping, NamedTuple, Sequence, Set, Tuple

from fleet_core.supervision.missions import MissionState, Status

NEAR = 0.5          # m; a robot nearer than this to a vertex is at it
_REPLY = re.compile(
    r'\bids? (?P<first>[A-Z]+\d+)(?: and (?P<second>[A-Z]+\d+))?(?: and)? job_id (?P<job>\S+) '
    'success')
_CANCELLED = re.compile(r'queuecancel cancelling "(?P<kind>[^"]*)" "(?P<value>[^"]*)" ')
_UPDATE = re.compile(r'QueueUpdate: (?P<segment>\S+) (?P<job>\S+) (?P<priority>-?\d+) '
                     r'(?P<status>\w+) (?P<substatus>\S+) Goal "(?P<goal>[^"]*)" '
                     r'"(?P<robot>[^"]*)" ')
_FINAL = frozenset(('Completed', 'Cancelled', 'Failed'))
_ENDS = frozenset(('Interrupted', 'Cancelling', 'Failed'))
_CHANGE = frozenset(('BeforeModify',))
_ORDER: Mapping[str, FrozenSet[str]] = {
    '': frozenset(('Pending',)),
    'Pending': frozenset(('Pending', 'UnAllocated', 'Cancelled', 'Failed', 'BeforeModify')),
    'UnAllocated': _ENDS | _CHANGE | {'Allocated', 'Pending'},
    'Allocated': _ENDS | _CHANGE | {'Driving'},
    'Driving': _ENDS | _CHANGE | {'Before', 'After', 'Completed'},
    'Before': _ENDS | _CHANGE | {'After', 'Completed'},
    'After': _ENDS | {'Completed'},
    'Interrupted': frozenset(('UnAllocated', 'Pending', 'Cancelling', 'Cancelled', 'Failed')),
    'Cancelling': frozenset(('Interrupted', 'Completed', 'Failed')),
    'BeforeModify': frozenset(('InterruptedByModify', 'AfterModify')),
    'InterruptedByModify': frozenset(('AfterModify',)),
    'AfterModify': frozenset(('Pending', 'UnAllocated', 'Allocated', 'Driving', 'Before')),
    **dict.fromkeys(_FINAL, frozenset()),
}
"""The states that may follow each state of a segment; Before is BeforePickup or BeforeDropoff."""
_OF_MISSION = {MissionState.SUCCEEDED: 'Completed', MissionState.FAILED: 'Failed',
               MissionState.CANCELLED: 'Cancelled', MissionState.REFUSED: 'Cancelled',
               MissionState.EXPIRED: 'Cancelled'}


class GoalPlace(NamedTuple):
    """The place of a goal, in m."""

    vertex: int
    x: float
    y: float


@dataclass
class WatchedSegment:
    """A segment, as the program knows it.

    state -- a state of `_ORDER`
    began -- when the segments before it were completed (s)
    drove -- when the program first got `Driving` for it (s); NaN: never
    """

    id: str
    state: str = ''
    robot: str = ''
    began: float = math.nan
    drove: float = math.nan


@dataclass
class WatchedJob:
    """A job that was `successfully queued`. Times in s of the virtual clock.

    line  -- the number of its line in the file
    ended -- when it ended (s); NaN: it is open
    """

    id: str
    line: int
    queued: float
    segments: List[WatchedSegment] = field(default_factory=list)
    ended: float = math.nan

    @property
    def state(self) -> str:
        """The newest state of its last segment."""
        return self.segments[-1].state


class Judge:
    """Checks all lines of the job server, and the places of all robots.

    goals -- places by the name of the goal
    jobs  -- the jobs that were queued, in their order
    wrong -- the errors that were found, in sentences
    """

    def __init__(self, goals: Mapping[str, GoalPlace]) -> None:
        self.jobs: List[WatchedJob] = []
        self.wrong: List[str] = []
        self._goals = goals
        self._cells: Dict[Tuple[int, int], List[GoalPlace]] = defaultdict(list)
        for place in goals.values():
            for x in (-1, 0, 1):
                for y in (-1, 0, 1):
                    self._cells[round(place.x) + x, round(place.y) + y].append(place)
        self._segments: Dict[str, Tuple[WatchedJob, int]] = {}
        self._visits: Dict[Tuple[str, int], float] = {}
        """The last time (s) at which each robot was at each vertex, by robot and vertex."""
        self._cancels: Set[Tuple[str, str]] = set()
        """Types and values of the cancellations that were accepted, in lower case."""

    # -- places of robots --------------------------------------------------------------------------

    def sees(self, robot: str, x: float, y: float, now: float) -> None:
        """Records where a robot is, in m."""
        for place in self._cells.get((round(x), round(y)), ()):
            if math.hypot(place.x - x, place.y - y) <= NEAR:
                self._visits[robot, place.vertex] = now

    # -- lines of the job server -------------------------------------------------------------------

    def hears_reply(self, line: int, replies: Sequence[str], now: float) -> None:
        """Records the replies to the command in a line of the file."""
        made: Dict[str, WatchedJob] = {}
        for reply in replies:
            queued = _REPLY.search(reply)
            cancelled = _CANCELLED.match(reply)
            if queued:
                job = made.setdefault(queued['job'], WatchedJob(queued['job'], line, now))
                for id in filter(None, (queued['first'], queued['second'])):
                    self._add(job, id, now)
            elif cancelled:
                self._cancels.add((cancelled['kind'].lower(), cancelled['value'].lower()))
        self.jobs += made.values()

    def _add(self, job: WatchedJob, id: str, now: float) -> None:
        if id in self._segments:
            self.wrong.append(f'The id {id} of job {job.id} is used twice.')
        self._segments[id] = job, len(job.segments)
        job.segments.append(WatchedSegment(id, began=math.nan if job.segments else now))

    def hears(self, update: str, now: float) -> None:
        """Judges a line that is sent to all programs."""
        told = _UPDATE.match(update)
        if told is None or told['segment'] not in self._segments:
            self.wrong.append(f'This line is about no job: {update.strip()}')
            return
        job, index = self._segments[told['segment']]
        one = job.segments[index]
        state = _state(told['status'], told['substatus'])
        if state not in _ORDER[one.state]:
            self._accuse(job, one, f'{state} was told after {one.state or "nothing"}')
        if told['status'] == 'InProgress' and index and (
                job.segments[index - 1].state != 'Completed'):
            self._accuse(job, one, f'{state} was told before the end of the segment before it')
        one.state, one.robot = state, told['robot']
        if state == 'Driving' and math.isnan(one.drove):
            one.drove = now
        if state == 'Completed':
            self._completed(job, index, self._goals[told['goal']].vertex, now)
        if index == len(job.segments) - 1 and state in _FINAL:
            job.ended = now

    def _completed(self, job: WatchedJob, index: int, vertex: int, now: float) -> None:
        one = job.segments[index]
        if not self._visits.get((one.robot, vertex), -math.inf) >= one.began:
            self._accuse(job, one, f'Completed was told, but {one.robot} was not at its goal')
        if index + 1 < len(job.segments):
            job.segments[index + 1].began = now

    def _accuse(self, job: WatchedJob, one: WatchedSegment, problem: str) -> None:
        self.wrong.append(f'Job {job.id} (line {job.line}), {one.id}: {problem}.')

    # -- the end -----------------------------------------------------------------------------------

    def ends(self, job: WatchedJob, last: Status, serials: Set[int]) -> None:
        """Judges a job at the end of the day.

        last    -- the last status of its mission
        serials -- the numbers of the missions that the fleet manager made for it
        """
        if len(serials) > 1:
            self.wrong.append(f'Job {job.id} (line {job.line}) became {len(serials)} missions.')
        expected = _OF_MISSION.get(last.state)
        told = [one.state for one in job.segments]
        if expected is None or any(state not in _FINAL for state in told):
            self.wrong.append(f'Job {job.id} (line {job.line}) has not ended: it is told as '
                              f'{", ".join(told)}, its mission is {last.state.name}.')
            return
        reached = len(told) if last.state is MissionState.SUCCEEDED else last.reached
        true = ['Completed'] * reached + [expected] * (len(told) - reached)
        if told != true:
            self.wrong.append(f'Job {job.id} (line {job.line}) was told as {", ".join(told)}, but '
                              f'its mission is {last.state.name} after {reached} stops.')
        if last.state is MissionState.CANCELLED and not self._may_be_cancelled(job):
            self.wrong.append(f'Job {job.id} (line {job.line}) was cancelled by no program.')

    def lost(self, job: WatchedJob) -> None:
        """Judges a job that never became a mission."""
        self.wrong.append(f'Job {job.id} (line {job.line}) never became a mission.')

    def _may_be_cancelled(self, job: WatchedJob) -> bool:
        return any(kind in ('status', 'robotname') or (kind, value) == ('jobid', job.id.lower())
                   or kind == 'id' and value in (one.id.lower() for one in job.segments)
                   for kind, value in self._cancels)


def _state(status: str, substatus: str) -> str:
    """Returns the state of `_ORDER` for a status and substatus."""
    if status != 'InProgress':
        return status
    return next((word for word in ('Before', 'After') if substatus.startswith(word)), substatus)
