"""Carries out the commands of clients: the part of OMRON's Fleet Manager that concerns jobs.

A command has replies for its own client, and changes of segments, which are sent to all clients
after the replies. The replies to a wrong argument are OMRON's two error lines.
"""
from __future__ import annotations

import time
from typing import Callable, Dict, Iterable, List, Mapping, NamedTuple, Optional, Tuple

from omron_jobs.core import job_words as words
from omron_jobs.core.command_line import CommandLine, read_line
from omron_jobs.core.job_book import (
    KEEP_ENDED,
    MOST_ENDED,
    JobBook,
    JobGoal,
    JobRefused,
)
from omron_jobs.core.job_words import SegmentKind, SegmentStatus
from omron_jobs.core.jobs import JobSegment, Place, QueuedJob, SegmentChange
from omron_jobs.core.robots import RobotNews, faults_of

MOST_GOALS = 50         # largest number of goals of one job
SHOWN_ENDED = 11        # largest number of ended segments in the list of queueShow
VERSION = '1.1.0'
PICKUP_PRIORITY, DROPOFF_PRIORITY = 10, 20
_LONGEST_NAME = 16      # characters of an unknown command that the reply repeats
DEFAULT_PRIORITIES = {SegmentKind.PICKUP: PICKUP_PRIORITY, SegmentKind.DROPOFF: DROPOFF_PRIORITY}
CANCELLABLE = (SegmentStatus.PENDING, SegmentStatus.IN_PROGRESS, SegmentStatus.INTERRUPTED)
_QUERIED = (*CANCELLABLE, SegmentStatus.COMPLETED, SegmentStatus.CANCELLED, SegmentStatus.FAILED)
QUEUING_MANAGER = 'Queuing Manager'


class JobSite:
    """The goals and robots of the fleet, as the fleet manager last showed them.

    goals -- vertices by name; None: there was no graph yet
    """

    def __init__(self) -> None:
        self.goals: Optional[Mapping[str, int]] = None
        self.robots: Mapping[str, RobotNews] = {}

    def vertex_of(self, name: str) -> Optional[int]:
        """Returns the vertex of the goal with this name or id, or None. Raises JobRefused."""
        if self.goals is None:
            raise JobRefused('knows no goals yet: is the fleet manager running?')
        if name in self.goals or not (name.isascii() and name.isdecimal()):
            return self.goals.get(name)
        return next((vertex for vertex in self.goals.values() if str(vertex) == name), None)


class JobReply(NamedTuple):
    """The result of a command.

    lines   -- for its client
    changes -- to be sent to all clients after the lines
    echo    -- whether lines of its client are sent back from now on; None: no change
    ends    -- whether the connection of its client ends
    """

    lines: Tuple[str, ...]
    changes: Tuple[SegmentChange, ...] = ()
    echo: Optional[bool] = None
    ends: bool = False


class JobCommands:
    """Carries out command lines. `local_time`: returns the local time.

    It has one method for each command in `_ROWS`.
    """

    def __init__(self, book: JobBook, site: JobSite,
                 local_time: Callable[[], time.struct_time] = time.localtime) -> None:
        self._book, self._site, self._local_time = book, site, local_time

    def carry_out(self, line: str) -> JobReply:
        """Carries out a line that has a word."""
        command = read_line(line)
        row = _TABLE.get(command.name.lower())
        if row is None:
            return JobReply((words.UNKNOWN.format(
                words.printed(command.name[:_LONGEST_NAME])),))
        if len(command.words) < row.required:
            return JobReply((words.USAGE.format(row.name, row.usage),))
        try:
            return row.act(self, command)
        except JobRefused as refusal:
            return JobReply((
                words.ERROR.format(words.printed(command.line)),
                words.ERROR_DESCRIPTION.format(row.name, words.printed(str(refusal)))))
        except OSError as error:
            return JobReply((words.SET_UP_ERROR.format(
                row.name, f'is not done: jobs cannot be stored ({error.strerror or error})'),))

    # -- jobs ------------------------------------------------------------------------------------

    def queue_pickup(self, command: CommandLine) -> JobReply:
        """Queues one pickup."""
        job = self._book.queue([self._goal(command, SegmentKind.PICKUP, 0, 1)],
                               command.text(2, 'job_id'))
        one, = job.segments
        return JobReply((words.PICKUP_QUEUED.format(one.goal, one.priority, one.id, job.id),),
                        changes_of(job))

    def queue_pickup_dropoff(self, command: CommandLine) -> JobReply:
        """Queues a pickup and the drop-off after it. If the next act of a robot is a drop-off at
        the goal of the pickup, this robot must serve the new job (a swap).
        """
        pickup = self._goal(command, SegmentKind.PICKUP, 0, 2)
        swap = self._book.swap_at(pickup.vertex)
        job = self._book.queue([pickup, self._goal(command, SegmentKind.DROPOFF, 1, 3)],
                               command.text(4, 'job_id'), swap=swap)
        one, two = job.segments
        line = words.PICKUP_DROPOFF_QUEUED.format(
            one.goal, two.goal, one.priority, two.priority, one.id, two.id, job.id)
        return JobReply((line + ('' if swap is None else words.LINKED_TO_JOB.format(swap.id)),),
                        changes_of(job))

    def queue_multi(self, command: CommandLine) -> JobReply:
        """Queues a job of several goals. The first one must be a pickup."""
        count, fields = command.number(0, 0), command.number(1, 0)
        if not 1 <= count <= MOST_GOALS or fields != 2:
            raise JobRefused(f'needs the number of goals (up to {MOST_GOALS}), and 2 fields for '
                             'each')
        if len(command.words) < 2 + 3 * count:
            raise JobRefused(f'needs a goal, pickup or dropoff, and a priority for each of {count} '
                             'goals')
        goals = [self._goal(command, _kind(command, 3 + k), 2 + k, 4 + k)
                 for k in range(0, 3 * count, 3)]
        if goals[0].kind is not SegmentKind.PICKUP:
            raise JobRefused('needs a pickup as its first goal')
        job = self._book.queue(goals, command.text(2 + 3 * count, 'job_id'))
        lines = []
        for k, one in enumerate(job.segments):
            line = words.MULTI_QUEUED.format(one.goal, one.priority, one.id, job.id)
            lines.append(line + (words.LINKED.format(job.segments[k - 1].id) if k else ''))
        return JobReply((*lines, words.END_OF_MULTI), changes_of(job))

    def _goal(self, command: CommandLine, kind: SegmentKind, name: int, priority: int) -> JobGoal:
        """Returns a goal. `name`, `priority`: the indices of these two arguments."""
        return JobGoal(kind, *self._place(command.words[name]),
                       command.number(priority, DEFAULT_PRIORITIES[kind]))

    def _place(self, goal: str) -> Place:
        vertex = self._site.vertex_of(goal)
        if vertex is None:
            raise JobRefused(f'no such goal "{goal}"')
        return Place(goal, vertex)

    def queue_cancel(self, command: CommandLine) -> JobReply:
        """Cancels the jobs that match, even if only one of their segments is named."""
        kind, value = command.words[0].lower(), command.words[1]
        echo, reason = command.text(2, 'echo'), command.text(3, 'reason')
        if kind == 'status':
            _status(value, CANCELLABLE)
        jobs = self._book.find(matching(kind, value, only_current=True), only_open=True)
        if not jobs and kind in ('id', 'jobid'):
            raise JobRefused(f'failed: there is no active job with {kind} "{value}"')
        changes = self._book.cancel(jobs, reason)
        return JobReply((words.CANCELLING.format(
            words.printed(command.words[0]), words.printed(value), echo, reason or words.NONE),),
            tuple(changes))

    def queue_modify(self, command: CommandLine) -> JobReply:
        """Changes the priority of a segment that waits, or the goal of a segment that no robot has
        reached yet.
        """
        id, what = command.words[0], command.words[1].lower()
        if what == 'priority':
            priority = command.number(2, 0)
            job, one = of_other_priority(self._book, id)
            changes = self._book.set_priority(job, one, priority)
            return JobReply((words.MODIFYING_PRIORITY.format(words.printed(id), priority),),
                            tuple(changes))
        if what != 'goal':
            raise JobRefused(f'needs goal or priority in the place of "{command.words[1]}"')
        place = self._place(command.words[2])
        job, one = of_other_goal(self._book, id)
        changes = self._book.set_goal(job, one, place)
        return JobReply((words.MODIFYING_GOAL.format(words.printed(id), place.goal),),
                        tuple(changes))

    def of_a_robot(self, command: CommandLine) -> JobReply:
        """Refuses a command that OMRON's robots accept, but its Fleet Manager does not."""
        raise JobRefused('is a command of a robot; the fleet manager does not take it')

    # -- lists -----------------------------------------------------------------------------------

    def queue_query(self, command: CommandLine) -> JobReply:
        """Lists the segments that match, by descending priority."""
        kind, value = command.words[0].lower(), command.words[1]
        echo = command.text(2, 'echo')
        if kind == 'status':
            _status(value, _QUERIED)
        matches = matching(kind, value)
        found = [SegmentChange(job.id, job.queued, one) for job in self._book.jobs
                 for one in job.segments if matches(job, one)]
        found.sort(key=lambda change: -change.segment.priority)
        return _list(words.QUERY, found, echo, words.END_OF_QUERY)

    def queue_show(self, command: CommandLine) -> JobReply:
        """Lists the robots, all open segments, and the `SHOWN_ENDED` segments that ended last."""
        echo = command.text(0, 'echo')
        every = [change for job in self._book.jobs for change in changes_of(job)]
        ended = [one.segment.number for one in every if one.segment.told.status.is_final]
        left_out = frozenset(ended[:-SHOWN_ENDED])
        shown = [one for one in every if one.segment.number not in left_out]
        listed = _list(words.SHOW, shown, echo, words.END_OF_SHOW)
        return listed._replace(lines=(*self._robot_lines('', echo), *listed.lines))

    def queue_show_completed(self, command: CommandLine) -> JobReply:
        """Lists the segments that are completed, the oldest first."""
        found = [change for job in self._book.jobs for change in changes_of(job)
                 if change.segment.told.status is SegmentStatus.COMPLETED]
        return _list(words.SHOW, found, command.text(0, 'echo'), words.END_OF_SHOW_COMPLETED)

    def queue_show_robot(self, command: CommandLine) -> JobReply:
        """Lists one robot, or all."""
        return JobReply((*self._robot_lines(self._robot(command), command.text(1, 'echo')),
                         words.END_OF_SHOW_ROBOT))

    def _robot(self, command: CommandLine) -> str:
        """Returns the robot that the first argument names, in lower case; empty: all.

        Raises JobRefused.
        """
        name = command.word(0)
        if name and name.lower() not in map(str.lower, self._site.robots):
            raise JobRefused(f'no such robot "{name}"')
        return name.lower()

    def _robot_lines(self, only: str, echo: str) -> List[str]:
        return [words.ROBOT.format(name, robot.status.value, robot.substatus,
                                   echo or words.NO_ECHO)
                for name, robot in sorted(self._site.robots.items())
                if only in ('', name.lower())]

    # -- the site --------------------------------------------------------------------------------

    def get_goals(self, command: CommandLine) -> JobReply:
        """Lists the goals."""
        return JobReply((*map(words.GOAL.format, self._site.goals or ()), words.END_OF_GOALS))

    def get_date_time(self, command: CommandLine) -> JobReply:
        """Shows the local date and time."""
        now = time.strftime(words.DATE, self._local_time())
        return JobReply((words.DATE_TIME.format(now),))

    def query_faults(self, command: CommandLine) -> JobReply:
        """Lists the faults of one robot or of all robots. A robot with a fault serves no jobs."""
        only, echo = self._robot(command), command.text(1, 'echo')
        return JobReply((*(
            words.ROBOT_FAULT.format(
                one.robot, one.type, one.name, one.name, one.text,
                str(one.is_application).lower(), echo or words.NO_ECHO)
            for one in faults_of(self._site.robots) if only in ('', one.robot.lower())),
            words.END_OF_FAULTS))

    def payload_query(self, command: CommandLine) -> JobReply:
        """Lists the payload slots: the robots of this fleet have none."""
        return JobReply((words.END_OF_PAYLOADS,))

    def payload_slot_count(self, command: CommandLine) -> JobReply:
        """Counts the payload slots: the robots of this fleet have none."""
        return JobReply((words.END_OF_SLOT_COUNT,))

    def get_config_section_list(self, command: CommandLine) -> JobReply:
        """Lists the sections of the configuration that clients read."""
        return JobReply((words.SECTION.format(QUEUING_MANAGER), words.END_OF_SECTIONS))

    def get_config_section_values(self, command: CommandLine) -> JobReply:
        """Shows the values of a section. Its name may contain blanks without quotation marks."""
        if command.rest.strip('"').lower() != QUEUING_MANAGER.lower():
            raise JobRefused(f'No section of name "{command.rest}"')
        return JobReply((*(words.SECTION_VALUE.format(name, value) for name, value in _SETTINGS),
                         words.END_OF_SECTION_VALUES))

    def get_data_store_group_list(self, command: CommandLine) -> JobReply:
        """Lists the groups of values that clients read."""
        return JobReply((*map(words.GROUP.format, self.groups()), words.END_OF_GROUPS))

    def get_data_store_group_values(self, command: CommandLine) -> JobReply:
        """Shows the values of a group."""
        groups = {name.lower(): values for name, values in self.groups().items()}
        values = groups.get(command.words[0].lower())
        if values is None:
            raise JobRefused(f'No group of name "{command.words[0]}"')
        return JobReply((*(words.GROUP_VALUE.format(*one) for one in values.items()),
                         words.END_OF_GROUP_VALUES))

    def groups(self) -> Dict[str, Dict[str, object]]:
        """Returns the groups of values: for each name of a group, its values by name."""
        counters = self._book.counters
        statuses = [one.told.status for job in self._book.jobs for one in job.segments]
        return {'FleetRobotInformation': {'Robots': len(self._site.robots)},
                'JobCounts': {'CompletedJobs': counters.completed,
                              'CancelledJobs': counters.cancelled},
                'QueueInformation': {'QueueSizePending': statuses.count(SegmentStatus.PENDING)},
                'Versions': {'omron_jobs': VERSION}}

    # -- the session -----------------------------------------------------------------------------

    def help(self, command: CommandLine) -> JobReply:
        """Lists the commands."""
        return JobReply((words.COMMANDS, *(
            words.HELP.format(row.name, f'{row.description} [{row.shortcut}]' if row.shortcut
                              else row.description) for row in _ROWS), words.END_OF_COMMANDS))

    def set_echo(self, command: CommandLine) -> JobReply:
        """Switches the echo on or off: whether lines of the client are sent back to the client."""
        word = command.words[0].lower()
        if word not in ('on', 'off'):
            raise JobRefused(f'needs "on" or "off" in the place of "{word}"')
        return JobReply((words.ECHO_TURNED.format(word),), echo=word == 'on')

    def quit(self, command: CommandLine) -> JobReply:
        """Ends the connection."""
        return JobReply((words.CLOSING,), ends=True)


def of_other_priority(book: JobBook, id: str) -> Tuple[QueuedJob, JobSegment]:
    """Returns the job and the segment with an id. Raises JobRefused if the priority is fixed."""
    return _modifiable(book, id, SegmentStatus.PENDING)


def of_other_goal(book: JobBook, id: str) -> Tuple[QueuedJob, JobSegment]:
    """Returns the job and the segment with an id. Raises JobRefused if the goal is fixed."""
    job, one = _modifiable(book, id, SegmentStatus.PENDING, SegmentStatus.IN_PROGRESS)
    if one.told.substatus in words.AFTER.values():
        raise JobRefused(f'failed: the robot works at the goal of "{one.id}" already')
    return job, one


def _modifiable(book: JobBook, id: str, *statuses: SegmentStatus) -> Tuple[QueuedJob, JobSegment]:
    for job in book.find(matching('id', id), only_open=True):
        for one in job.segments:
            if (one.id.lower() == id.lower() and one.told.status in statuses
                    and job.cancel is None):
                return job, one
    names = ' or '.join(status.value for status in statuses)
    raise JobRefused(f'failed: no segment "{id}" is {names}')


_Matches = Callable[[QueuedJob, JobSegment], bool]


def matching(kind: str, value: str, only_current: bool = False) -> _Matches:
    """Returns a function that tests whether a command's type and value name a segment.

    only_current -- whether robotName and status match only the segment that is served or comes next
    Raises JobRefused.
    """
    wanted = value.lower()

    def is_current(job: QueuedJob, one: JobSegment) -> bool:
        return not only_current or one == job.current
    found: Optional[_Matches] = {
        'id': lambda job, one: one.id.lower() == wanted,
        'jobid': lambda job, one: job.id.lower() == wanted,
        'robotname': lambda job, one: one.told.robot.lower() == wanted and is_current(job, one),
        'status': lambda job, one: (one.told.status.value.lower() == wanted
                                    and is_current(job, one)),
    }.get(kind)
    if found is None:
        raise JobRefused(f'needs id, jobId, robotName or status in the place of "{kind}"')
    return found


def _status(value: str, known: Iterable[SegmentStatus]) -> None:
    """Raises JobRefused unless `value` is one of the statuses `known`."""
    names = [one.value.lower() for one in known]
    if value.lower() not in names:
        raise JobRefused(f'needs {", ".join(names)} in the place of "{value}"')


def _kind(command: CommandLine, index: int) -> SegmentKind:
    word = command.words[index]
    try:
        return SegmentKind(word.upper())
    except ValueError:
        raise JobRefused(f'needs pickup or dropoff in the place of "{word}"') from None


def changes_of(job: QueuedJob) -> Tuple[SegmentChange, ...]:
    """Returns all segments of a job, to be sent to all clients."""
    return tuple(SegmentChange(job.id, job.queued, one) for one in job.segments)


def _list(form: str, found: Iterable[SegmentChange], echo: str, end: str) -> JobReply:
    return JobReply((*(_written(form, one, echo) for one in found), end))


def update_line(change: SegmentChange) -> str:
    """Returns the line that informs clients of a change."""
    return _written(words.UPDATE, change, '')


def _written(form: str, change: SegmentChange, echo: str) -> str:
    segment = change.segment
    return form.format(
        segment=segment.id, job=change.job, priority=segment.priority,
        state=f'{segment.told.status.value} {segment.told.substatus}', goal=segment.goal,
        robot=words.QUOTED.format(segment.told.robot or words.NONE),
        dates=f'{words.date(change.queued)} {words.date(segment.ended)}',
        echo=echo or words.NO_ECHO, fails=0)


_SETTINGS: Tuple[Tuple[str, object], ...] = (
    ('DefaultPickupPriority', PICKUP_PRIORITY), ('DefaultDropoffPriority', DROPOFF_PRIORITY),
    ('MaxNumberOfCompletedItems', MOST_ENDED), ('DeleteCompletedItemsMinutes', KEEP_ENDED))


class _Row(NamedTuple):
    """A command. `required`: the least number of arguments."""

    name: str
    shortcut: str
    usage: str
    required: int
    description: str
    act: Callable[[JobCommands, CommandLine], JobReply]


_ROWS: Tuple[_Row, ...] = tuple(sorted((
    _Row('echo', '', '<on/off>', 1, 'with args sets echo', JobCommands.set_echo),
    _Row('getConfigSectionList', '', '', 0, 'Gets the list of sections in the config',
         JobCommands.get_config_section_list),
    _Row('getConfigSectionValues', '', '<section>', 1, 'Gets the values of a section in the config',
         JobCommands.get_config_section_values),
    _Row('getDataStoreGroupList', 'dsgl', '', 0, 'Gets the list of groups in the Data Store',
         JobCommands.get_data_store_group_list),
    _Row('getDataStoreGroupValues', 'dsgv', '<group>', 1,
         'Gets the values of a group in the Data Store', JobCommands.get_data_store_group_values),
    _Row('getDateTime', '', '', 0, 'gets the date and time', JobCommands.get_date_time),
    _Row('getGoals', '', '', 0, 'gets a list of goals in the map', JobCommands.get_goals),
    _Row('help', '', '', 0, 'gives the listing of available commands', JobCommands.help),
    _Row('payloadQuery', 'pq', '[robot] [slot] [echo]', 0, 'Queries the payload of the robots',
         JobCommands.payload_query),
    _Row('payloadSlotCount', 'psc', '[robot] [echo]', 0, 'Counts the payload slots of the robots',
         JobCommands.payload_slot_count),
    _Row('queryFaults', 'qf', '[robot] [echo]', 0, 'Shows the faults of the robots',
         JobCommands.query_faults),
    _Row('queueCancel', 'qc', '<id, jobId, robotName or status> <value> [echo or "default"] '
         '[reason]', 2, 'Cancels jobs', JobCommands.queue_cancel),
    _Row('queueModify', 'qmod', '<id> <goal or priority> <value>', 3,
         'Modifies a segment of a job', JobCommands.queue_modify),
    _Row('queueMulti', 'qm', '<number of goals> <2> <goal> <pickup or dropoff> '
         '<priority or "default"> ... [job_id]', 2, 'Queues a job of several goals',
         JobCommands.queue_multi),
    _Row('queuePickup', 'qp', '<goal> [priority or "default"] [job_id]', 1,
         'Queues a pickup goal for any appropriate robot', JobCommands.queue_pickup),
    _Row('queuePickupDropoff', 'qpd', '<pickup goal> <dropoff goal> [priority1 or "default"] '
         '[priority2 or "default"] [job_id]', 2,
         'Queues a pickup and a dropoff goal for any appropriate robot',
         JobCommands.queue_pickup_dropoff),
    _Row('queueQuery', 'qq', '<id, jobId, robotName or status> <value> [echo]', 2,
         'Queries the jobs', JobCommands.queue_query),
    _Row('queueShow', 'qs', '[echo]', 0, 'Shows the robots and the jobs', JobCommands.queue_show),
    _Row('queueShowCompleted', 'qsc', '[echo]', 0, 'Shows the completed jobs',
         JobCommands.queue_show_completed),
    _Row('queueShowRobot', 'qsr', '[robot or "default"] [echo]', 0, 'Shows the robots',
         JobCommands.queue_show_robot),
    _Row('quit', '', '', 0, 'closes this connection to the server', JobCommands.quit),
), key=lambda row: row.name.lower()))
_OF_ROBOTS = tuple(
    _Row(name, shortcut, '', 0, '', JobCommands.of_a_robot) for name, shortcut in (
        ('queueDropoff', 'qd'), ('queueCancelLocal', 'qcl'), ('queueModifyLocal', 'qmodl'),
        ('queueQueryLocal', 'qql'), ('queueShowRobotLocal', 'qsrl'), ('pauseTaskCancel', ''),
        ('waitTaskCancel', ''), ('modeUnlock', '')))
"""Commands of robots, which clients may send by mistake. They are refused, and not in the help."""
_TABLE: Dict[str, _Row] = {key.lower(): row for row in (*_ROWS, *_OF_ROBOTS)
                           for key in (row.name, row.shortcut) if key}
