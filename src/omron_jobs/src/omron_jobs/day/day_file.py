"""Reads a day of jobs: each line is a time, and the command line of a warehouse program.

    # time   command
    06:00:00 queuePickupDropoff 18 39 default default P1
    06:00:30 queueMulti 3 2 6 pickup 10 27 dropoff default 52 dropoff default M1
    06:01:10 queueModify @P1.2 goal 52
    06:02    queueCancel jobId P1 default late
    06:30    restart job_server

`@P1.2` stands for the id of the second segment of the job P1. `restart` ends the job server, or the
fleet manager, and starts it again.
"""
from __future__ import annotations

import difflib
import os
import re
from typing import Callable, Collection, Dict, Iterable, List, NamedTuple, Tuple, Union

from fleet_core.files.errors import FileError
from omron_jobs.core.command_line import CommandLine, read_line
from omron_jobs.core.job_book import JobRefused
from omron_jobs.core.job_commands import CANCELLABLE, MOST_GOALS
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import WrongYaml

RESTART = 'restart'
_QUEUING = frozenset(('queuePickup', 'queuePickupDropoff', 'queueMulti'))
RESTARTED = ('job_server', 'fleet_manager')
_TIME = re.compile(r'([01]\d|2[0-3]):([0-5]\d)(?::([0-5]\d))?\Z', re.ASCII)
_SEGMENT = re.compile(r'@(?P<job>\S+)\.(?P<number>[1-9]\d?)\Z', re.ASCII)
_OWN_ID = re.compile(r'JOB\d+\Z', re.ASCII | re.IGNORECASE)


class DayLine(NamedTuple):
    """One line of a day.

    number -- number of the line in the file, from 1
    at     -- its time, s after midnight
    name   -- name of the command
    words  -- its arguments, without quotation marks
    """

    number: int
    at: float
    name: str
    words: Tuple[str, ...]

    @property
    def queues(self) -> bool:
        """Whether the line queues a job."""
        return self.name in _QUEUING

    def command(self, segment_of: Callable[[str, int], str]) -> str:
        """Returns the line for the job server. `segment_of` returns the id of a job's segment."""
        words = []
        for word in self.words:
            named = _SEGMENT.match(word)
            text = segment_of(named['job'], int(named['number'])) if named else word
            words.append(f'"{text}"' if ' ' in text else text)
        return ' '.join((self.name, *words))


class _WrongLine(ValueError):
    """A line that cannot be used. The text is a clause with the reason and the remedy."""


class _Reader:
    """Reads lines, and keeps the facts about earlier lines that later lines need.

    goals -- names of the goals
    jobs  -- number of segments of each job to which a line gives an id
    """

    def __init__(self, goals: Collection[str]) -> None:
        self._goals = frozenset(goals)
        self._jobs: Dict[str, int] = {}
        self._latest = 0.0

    def read(self, number: int, text: str) -> DayLine:
        """Reads a line. Raises _WrongLine."""
        time, _, rest = text.strip().partition(' ')
        at = _seconds(time)
        if at < self._latest:
            raise _WrongLine(f'{time} is before the line above: sort the lines by time')
        self._latest = at
        if not rest.strip():
            raise _WrongLine(f'there is no command after {time}: give one of {", ".join(_READERS)}')
        command = read_line(rest)
        if command.name not in _READERS:
            near = difflib.get_close_matches(command.name, _READERS, 1)
            meant = f'did you mean {near[0]}' if near else f'give one of {", ".join(_READERS)}'
            raise _WrongLine(f'there is no command {command.name!r}: {meant}')
        try:
            _READERS[command.name](self, command)
        except JobRefused as refusal:
            raise _WrongLine(f'{command.name} {refusal}') from None
        return DayLine(number, at, command.name, tuple(command.words))

    def pickup(self, command: CommandLine) -> None:
        """Checks `queuePickup GOAL [PRIORITY] [JOB_ID]`."""
        _count(command, 1, 3)
        self._goal(command.words[0])
        command.number(1, 0)
        self._queue(command.text(2, 'job_id'), 1)

    def pickup_dropoff(self, command: CommandLine) -> None:
        """Checks `queuePickupDropoff GOAL GOAL [PRIORITY] [PRIORITY] [JOB_ID]`."""
        _count(command, 2, 5)
        for goal in command.words[:2]:
            self._goal(goal)
        command.number(2, 0)
        command.number(3, 0)
        self._queue(command.text(4, 'job_id'), 2)

    def multi(self, command: CommandLine) -> None:
        """Checks `queueMulti N 2 GOAL KIND PRIORITY ... [JOB_ID]`."""
        count = command.number(0, 0)
        if not 1 <= count <= MOST_GOALS or command.number(1, 0) != 2:
            raise _WrongLine(f'queueMulti needs a number of goals from 1 to {MOST_GOALS}, then 2')
        _count(command, 2 + 3 * count, 3 + 3 * count)
        for k in range(2, 2 + 3 * count, 3):
            self._goal(command.words[k])
            if command.words[k + 1] not in ('pickup', 'dropoff'):
                raise _WrongLine(f'{command.words[k + 1]!r} stands in the place of pickup or '
                                 'dropoff')
            command.number(k + 2, 0)
        if command.words[3] != 'pickup':
            raise _WrongLine('the first goal of queueMulti must be a pickup')
        self._queue(command.text(2 + 3 * count, 'job_id'), count)

    def cancel(self, command: CommandLine) -> None:
        """Checks `queueCancel TYPE VALUE [ECHO] [REASON]`."""
        _count(command, 2, 4)
        kind, value = command.words[:2]
        if kind == 'id':
            self._segment(value)
        elif kind == 'jobId':
            self._job(value)
        elif kind == 'status':
            known = [status.value.lower() for status in CANCELLABLE]
            if value.lower() not in known:
                raise _WrongLine(f'there is no status {value!r} to be cancelled: give one of '
                                 f'{", ".join(known)}')
        elif kind != 'robotName':
            raise _WrongLine(f'queueCancel has no type {kind!r}: give id, jobId, robotName or '
                             'status')
        command.text(2, 'echo')
        command.text(3, 'reason')

    def modify(self, command: CommandLine) -> None:
        """Checks `queueModify @JOB.N goal|priority VALUE`."""
        _count(command, 3, 3)
        segment, what, value = command.words
        self._segment(segment)
        if what == 'goal':
            self._goal(value)
        elif what == 'priority':
            command.number(2, 0)
        else:
            raise _WrongLine(f'queueModify changes goal or priority, not {what!r}')

    def restart(self, command: CommandLine) -> None:
        """Checks `restart job_server|fleet_manager`."""
        _count(command, 1, 1)
        if command.words[0] not in RESTARTED:
            raise _WrongLine(f'{command.words[0]!r} cannot be restarted: give '
                             f'{" or ".join(RESTARTED)}')

    def _goal(self, name: str) -> None:
        if name not in self._goals:
            near = difflib.get_close_matches(name, sorted(self._goals), 1)
            raise _WrongLine(f'the graph has no goal {name!r}'
                             + (f': did you mean {near[0]}' if near else ''))

    def _queue(self, id: str, segments: int) -> None:
        if not id:
            return
        if _OWN_ID.match(id):
            raise _WrongLine(f'{id} is an id that the job server makes: give another one')
        if id.lower() in self._jobs:
            raise _WrongLine(f'a line above queues the job {id}: give each job an id of its own')
        self._jobs[id.lower()] = segments

    def _job(self, id: str) -> int:
        if id.lower() not in self._jobs:
            raise _WrongLine(f'no line above queues a job with the id {id!r}')
        return self._jobs[id.lower()]

    def _segment(self, word: str) -> None:
        named = _SEGMENT.match(word)
        if named is None:
            raise _WrongLine(f'{word!r} is no segment of a job: give for example @P1.2, the second '
                             'segment of the job P1')
        count = self._job(named['job'])
        if int(named['number']) > count:
            raise _WrongLine(f'the job {named["job"]} has only {count} segments')


_READERS: Dict[str, Callable[[_Reader, CommandLine], None]] = {
    'queuePickup': _Reader.pickup, 'queuePickupDropoff': _Reader.pickup_dropoff,
    'queueMulti': _Reader.multi, 'queueCancel': _Reader.cancel, 'queueModify': _Reader.modify,
    RESTART: _Reader.restart}


def _seconds(time: str) -> float:
    found = _TIME.match(time)
    if found is None:
        raise _WrongLine(f'{time!r} is no time of a day: give HH:MM:SS or HH:MM')
    hours, minutes, seconds = found.groups('0')
    return 3600.0 * int(hours) + 60.0 * int(minutes) + int(seconds)


def _count(command: CommandLine, least: int, most: int) -> None:
    """Raises _WrongLine for a command with too few or too many arguments."""
    count = len(command.words)
    if not least <= count <= most:
        wanted = str(least) if least == most else f'{least} to {most}'
        raise _WrongLine(f'{command.name} has {count} arguments here, but takes {wanted}')


def load_day(path: Union[str, os.PathLike[str]], goals: Collection[str]) -> List[DayLine]:
    """Reads a day of jobs between these goals. Raises FileError."""
    try:
        text = strict_yaml.read_file(path).decode()
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None
    except UnicodeDecodeError:
        raise FileError(path, 'this is not UTF-8 text: save it as UTF-8') from None
    return read_day(text.splitlines(), goals, path)


def read_day(lines: Iterable[str], goals: Collection[str],
             path: Union[str, os.PathLike[str]] = 'day') -> List[DayLine]:
    """Reads the lines of a file. Raises FileError."""
    reader, found = _Reader(goals), []
    for number, text in enumerate(lines, 1):
        if text.strip() and not text.lstrip().startswith('#'):
            try:
                found.append(reader.read(number, text))
            except _WrongLine as wrong:
                raise FileError(path, str(wrong), number) from None
    if not any(line.queues for line in found):
        raise FileError(path, 'the day has no jobs: give at least one line with '
                              f'{", ".join(sorted(_QUEUING))}')
    return found
