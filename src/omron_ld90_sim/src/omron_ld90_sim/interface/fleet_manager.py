"""A simulated OMRON Fleet Manager: it accepts jobs over ARCL on its own port, for the robots of
this simulation. `job_queue` describes the words and lines.

Its table of commands is separate: it shares no code with the driver or with `omron_jobs`.
"""
from __future__ import annotations

import re
import time
from dataclasses import replace
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from omron_ld90_sim.behaviour import activities
from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import ActivityFailure, Script
from omron_ld90_sim.behaviour.task import find_goal
from omron_ld90_sim.clock import SimClock, Ticker
from omron_ld90_sim.interface.configuration_table import default_configuration
from omron_ld90_sim.interface.dialect import Dialect
from omron_ld90_sim.interface.job_queue import (
    DoubleJob,
    JobQueue,
    NewSegment,
    NotModifiable,
    QueueRobot,
    QueueSegment,
    line_of,
)
from omron_ld90_sim.interface.session import Impairment, LoginPhase, SimSession

CYCLE = 0.1             # s between two distributions of jobs
PICKUP, DROPOFF = 10, 20    # priorities by default
MOST_GOALS = 50
_WORD = re.compile(r'"([^"]*)"|(\S+)')
_CANCELLED = ('inprogress', 'pending', 'interrupted')
_QUERIED = (*_CANCELLED, 'completed', 'cancelled', 'failed')


class BadJob(ValueError):
    """A wrong command of a client; the text is sent as CommandErrorDescription."""


class SimFleetManager:
    """The Fleet Manager without I/O. `goals` are the names of the goals on the robots' map.

    It has many attributes because it is the server of a port and the host of sessions.
    """

    def __init__(self, clock: SimClock, robots: Sequence[QueueRobot],
                 goals: Callable[[], Sequence[str]], password: str) -> None:
        self.clock, self.password, self._goals = clock, password, goals
        self.impairment, self.dialect = Impairment(), Dialect()
        self.configuration = default_configuration()
        self.online = self.accepting = True
        self.outgoing_wanted = False
        self.sessions: List[SimSession] = []
        self.queue = JobQueue(robots, self._date, self._announce)
        self._count = 0
        Ticker(clock, CYCLE, self.queue.advance)

    # -- what a port and a session need --------------------------------------------------------

    def connect(self) -> SimSession:
        """Begins the session of a new client."""
        self._count += 1
        session = SimSession(self, self._count)
        self.sessions.append(session)
        return session

    def connect_outgoing(self) -> SimSession:
        """Raises NotImplementedError: there is no address to dial."""
        raise NotImplementedError('a simulated Fleet Manager does not dial out')

    def forget(self, session: SimSession) -> None:
        """Removes a session that has ended."""
        session.phase = LoginPhase.CLOSED
        if session in self.sessions:
            self.sessions.remove(session)

    def shut_down(self) -> None:
        """Ends all sessions with a farewell. The jobs stay."""
        for session in list(self.sessions):
            session.send('Shutting down server')
            session.close()

    def log(self, number: int, direction: str, line: bytes) -> None:
        """Keeps no log."""

    def execute(self, session: SimSession, line: str) -> None:
        """Carries out a command line."""
        name, rest = [*line.split(None, 1), '', ''][:2]
        row = _TABLE.get(name.lower())
        if row is None:
            session.send(f'Unknown command {name}')
            return
        words = [quoted or plain for quoted, plain in _WORD.findall(rest)]
        if len(words) < row[1]:
            session.send(f'usage: {row[0]} {row[2]}')
            return
        try:
            row[3](self, session, words)
        except BadJob as problem:
            session.send(f'CommandError: {line}')
            session.send(f'CommandErrorDescription: {problem}')

    # -- jobs ----------------------------------------------------------------------------------

    def goal(self, name: str, command: str) -> str:
        """Returns the goal with that name, ignoring case. Raises BadJob."""
        found = next((goal for goal in self._goals() if goal.lower() == name.lower()), None)
        if found is None:
            raise BadJob(f'{command} no such goal "{name}"')
        return found

    def add(self, wanted: Sequence[NewSegment], job: str,
            swap: Optional[QueueSegment] = None) -> List[QueueSegment]:
        """Queues a job; a swap waits for the drop-off `swap`. Raises BadJob."""
        try:
            return self.queue.add(wanted, job, swap)
        except DoubleJob as problem:
            raise BadJob(str(problem)) from None

    @property
    def goals(self) -> Sequence[str]:
        """The names of all goals."""
        return self._goals()

    def _announce(self, segment: QueueSegment) -> None:
        for session in list(self.sessions):
            if session.phase is LoginPhase.OPEN:
                session.send(line_of('QueueUpdate', segment))

    def _date(self) -> str:
        return time.strftime('%m/%d/%Y %H:%M:%S')


class QueuedUnit:
    """A simulated robot to which the Fleet Manager gives jobs."""

    def __init__(self, name: str, robot: SimRobot) -> None:
        self.name, self._robot = name, robot

    @property
    def is_free(self) -> bool:
        """Whether the robot can drive and does nothing."""
        return self._robot.can_drive and self._robot.activity is None

    def drive(self, goal: str, ended: Callable[[bool], None]) -> None:
        """Drives to a goal."""
        robot = self._robot
        place = find_goal(robot.document, goal)
        if place is None:       # another map was loaded
            robot.executive.outside(lambda: ended(False))
            return
        drive = activities.go_to_goal(robot, place)

        def script() -> Script:
            is_there = False
            try:
                yield from drive.script
                is_there = True
            except ActivityFailure:
                raise
            finally:
                robot.clock.after(0.0, lambda: ended(is_there))
        robot.start(replace(drive, script=script()))

    def stop(self) -> None:
        """Ends the drive."""
        self._robot.stop()


# -- the commands ------------------------------------------------------------------------------

_Handler = Callable[[SimFleetManager, SimSession, List[str]], None]


def _priority(word: str, default: int) -> int:
    if word.lower() == 'default':
        return default
    try:
        return int(word)
    except ValueError:
        raise BadJob(f'"{word}" is no priority') from None


def _at(words: List[str], index: int, default: str = '') -> str:
    return words[index] if len(words) > index else default


def _pickup(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    goal = manager.goal(words[0], 'queuePickup')
    priority = _priority(_at(words, 1, 'default'), PICKUP)
    added = manager.add([NewSegment(goal, 'PICKUP', priority)], _at(words, 2))
    session.send(f'queuepickup goal "{goal}" with priority {priority} id {added[0].id} and job_id '
                 f'{added[0].job} successfully queued')
    manager.queue.announce(added)


def _pickup_dropoff(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    goals = [manager.goal(word, 'queuePickupDropoff') for word in words[:2]]
    first = _priority(_at(words, 2, 'default'), PICKUP)
    second = _priority(_at(words, 3, 'default'), DROPOFF)
    swap = manager.queue.swap_at(goals[0])
    added = manager.add([NewSegment(goals[0], 'PICKUP', first),
                         NewSegment(goals[1], 'DROPOFF', second)], _at(words, 4), swap)
    linked = f' and linked to job_id {swap.job}' if swap is not None else ''
    session.send(f'queuepickupdropoff goals "{goals[0]}" and "{goals[1]}" with priorities {first} '
                 f'and {second} ids {added[0].id} and {added[1].id} job_id {added[0].job} '
                 f'successfully queued{linked}')
    manager.queue.announce(added)


def _multi(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    count = _priority(words[0], 0)
    if not 0 < count <= MOST_GOALS or words[1] != '2' or len(words) < 2 + 3 * count:
        raise BadJob('queueMulti bad number of goals or fields')
    wanted: List[NewSegment] = []
    for n in range(count):
        goal, kind, priority = words[2 + 3 * n:5 + 3 * n]
        if kind.lower() not in ('pickup', 'dropoff') or not n and kind.lower() != 'pickup':
            raise BadJob(f'queueMulti bad kind "{kind}"')
        wanted.append(NewSegment(
            manager.goal(goal, 'queueMulti'), kind.upper(),
            _priority(priority, PICKUP if kind.lower() == 'pickup' else DROPOFF)))
    added = manager.add(wanted, _at(words, 2 + 3 * count))
    for one in added:
        linked = f' and linked to {one.after}' if one.after else ''
        session.send(f'QueueMulti: goal "{one.goal}" with priority {one.priority} id {one.id} and '
                     f'job_id {one.job} successfully queued{linked}')
    session.send('EndQueueMulti')
    manager.queue.announce(added)


def _find(manager: SimFleetManager, command: str, words: List[str],
          statuses: Sequence[str]) -> List[QueueSegment]:
    if words[0].lower() not in ('id', 'jobid', 'robotname', 'status'):
        raise BadJob(f'{command} bad type "{words[0]}"')
    if words[0].lower() == 'status' and words[1].lower() not in statuses:
        raise BadJob(f'{command} bad status "{words[1]}"')
    return manager.queue.find(words[0], words[1])


def _cancel(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    found = _find(manager, 'queueCancel', words, _CANCELLED)
    reason = _at(words, 3, 'None')
    if not any(one.is_open for one in found):
        raise BadJob(f'queueCancel failed: nothing has {words[0]} "{words[1]}"')
    echo = _at(words, 2, 'default')
    session.send(f'queuecancel cancelling "{words[0]}" "{words[1]}" '
                 f'"{"" if echo == "default" else echo}" "{reason}" from queue')
    manager.queue.cancel(found, reason)


def _modify(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    id, field, value = words[:3]
    try:
        segment = manager.queue.check_modifiable(id)
    except NotModifiable:
        raise BadJob(f'queueModify no segment "{id}" that can be modified') from None
    if field.lower() == 'goal':
        goal, priority = manager.goal(value, 'queueModify'), segment.priority
        session.send(f'queuemodify modifying id {id} goal "{goal}"')
    elif field.lower() == 'priority':
        goal, priority = segment.goal, _priority(value, segment.priority)
        session.send(f'queuemodify modifying id {id} priority {priority}')
    else:
        raise BadJob(f'queueModify bad type "{field}"')
    manager.queue.modify(segment, goal, priority)


def _query(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    found = _find(manager, 'queueQuery', words, _QUERIED)
    for one in sorted(found, key=lambda one: -one.priority):
        session.send(line_of('QueueQuery', one, _at(words, 2)))
    session.send('EndQueueQuery')


def _show(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    _robots(manager, session, words[:0])
    for one in manager.queue.segments[-11:]:
        session.send(line_of('QueueShow', one, _at(words, 0)))
    session.send('EndQueueShow')


def _show_robot(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    _robots(manager, session, words)
    session.send('EndQueueShowRobot')


def _robots(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    wanted, echo = _at(words, 0, 'default'), _at(words, 1) or '""'
    for robot in manager.queue.robots:
        if wanted.lower() in ('default', robot.name.lower()):
            served: Optional[QueueSegment] = next(
                (one for one in manager.queue.find('robotName', robot.name) if one.is_open), None)
            state = (f'{served.status} {served.substatus}' if served is not None
                     else 'Available Available' if robot.is_free else 'UnAvailable Interrupted')
            session.send(f'QueueRobot: "{robot.name}" {state} {echo}')


def _date_time(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    session.send(f'DateTime: {manager.queue.date()}')


def _goals(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    for goal in manager.goals:
        session.send(f'Goal: {goal}')
    session.send('End of goals')


def _echo(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    if words:
        session.echo = words[0].lower() == 'on'
    session.send(f'Echo {"turned" if words else "is"} {"on" if session.echo else "off"}.')


def _help(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    session.send('Commands:')
    for name, _, usage, _ in sorted(_TABLE.values(), key=lambda row: row[0].lower()):
        session.send(f'{name:>15}{"":10}{usage}')
    session.send('End of commands')


def _quit(manager: SimFleetManager, session: SimSession, words: List[str]) -> None:
    session.send('Closing connection')
    session.close()


_ROWS: Tuple[Tuple[str, int, str, _Handler], ...] = (
    ('queuePickup', 1, '<goal> [priority or default] [jobId]', _pickup),
    ('queuePickupDropoff', 2,
     '<pickup goal> <dropoff goal> [priority1 or default] [priority2 or default] [jobId]',
     _pickup_dropoff),
    ('queueMulti', 5, '<number of goals> 2 <goal> <pickup or dropoff> <priority or default> ... '
                      '[jobId]', _multi),
    ('queueCancel', 2, '<type> <value> [echo] [reason]', _cancel),
    ('queueModify', 3, '<id> <goal or priority> <value>', _modify),
    ('queueQuery', 2, '<type> <value> [echo]', _query),
    ('queueShow', 0, '[echo]', _show),
    ('queueShowRobot', 0, '[robot or default] [echo]', _show_robot),
    ('getDateTime', 0, '', _date_time),
    ('getGoals', 0, '', _goals),
    ('echo', 0, '[on or off]', _echo),
    ('help', 0, '', _help),
    ('quit', 0, '', _quit),
)
_TABLE: Dict[str, Tuple[str, int, str, _Handler]] = {row[0].lower(): row for row in _ROWS}
