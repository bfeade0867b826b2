"""Decides with a table which command a line of the robot is about, and what the line means.

The robot answers in the order of sending, but its lines carry no id. Only the text of a line, and
what the robot did before, connect the line with a command. The table `ATTRIBUTIONS` has one part
for each kind of consequence that a line may have (`LinePart`). In each part, the first row that
holds decides. A row may also find, among the commands that were sent, those that the line ends,
acknowledges or continues. `drives` records the consequences. If no line names a drive, `judgements`
compares the drive with the robot's activity.

Each row names its source: a page of OMRON's ARCL manual I617-E-01, or of I617-E-02 if the row says
so. `observed` means that programs for real robots rely on the statement. `assumed` means that no
source contains the statement: check it with a robot.
"""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import Enum
from typing import Any, Callable, Iterable, List, Mapping, Sequence, Tuple, Type, Union

from omron_arcl import replies
from omron_arcl.activity import (
    HALTED,
    STANDING,
    Activity,
    ActivityKind,
    activity_of,
    read_activity,
)
from omron_arcl.command_line import parse_command
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import DriveCourse
from omron_arcl.drives import REFUSED, names_of
from omron_arcl.errors import InvalidCommand
from omron_arcl.execution import Execution, Outcome
from omron_arcl.heard import SelfStop, StopOf
from omron_arcl.judgements import ABOUT_THE_DOCK, Observation, acknowledges, fits
from omron_arcl.parser import parse_line
from omron_arcl.records import DriveRecord, MotionCause
from omron_arcl.replies import Reply, coordinates, names_emergency_stop, readable
from omron_arcl.secret import redact_passwords

_TO_GOAL = ActivityKind.GOING_TO_GOAL
_CUT_NAME = 16  # length to which the robot shortens the name of an unknown command
_ROUNDED = 2.0  # mm or degrees by which a point may differ when the robot repeats it
_NO_GOAL = re.compile(r'\bno (such )?goal\b|\bgoal\b.*\b(not found|not exist|unknown)\b|'
                      r'\b(unknown|invalid) goal\b', re.IGNORECASE)
_ABOUT_DRIVING = re.compile(r'\b(path|goal|plan|route|drive|driving|reach|dock)\b', re.IGNORECASE)
_ABOUT_LOCALIZING = re.compile(r'locali[sz]', re.IGNORECASE)
# Activities that some robots report with a word such as `Docking` instead of a docking state.
_IN_WORDS = {ActivityKind.DOCKING: DriveCourse.INTO_THE_DOCK,
             ActivityKind.UNDOCKING: DriveCourse.OUT_OF_THE_DOCK}
# Lines to all clients, and refusals. They never answer a command whose answer is undocumented.
_NO_ANSWER = frozenset((
    replies.DockingStatus, replies.GoingTo, replies.GoingToPoint, replies.ArrivedAt,
    replies.ArrivedAtPoint, replies.Parking, replies.Stopping, replies.Stopped,
    replies.Interrupted, replies.RobotError, replies.Failure, replies.EStop, replies.Motors,
    replies.WaitState, replies.OneLineStatus, replies.StatusText, replies.RangeReading,
    replies.ExternalIOUpdate,
    replies.MapChanged, replies.ConfigurationChanged, replies.Notice, replies.CommandError,
    replies.CommandErrorDescription, replies.UnknownCommand, replies.SetUpError,
    replies.Usage))


class LinePart(Enum):
    """One of the questions that a line may answer. Each has its own part of the table."""

    HALT = 'the cause of a `Stopping`: our stop, the robot itself or another client'
    ENDED = 'the drives that the line is about, and that have ended for their givers'
    COMMAND = 'the drive, or the refused command, that the line is about'
    START = 'the giver for which the robot sets out, if not for a command under way'
    ANSWER = 'the query or stop that the line answers'


class Means(Enum):
    """What a line means for a command that it does not end."""

    ACKNOWLEDGED = 'the robot obeys it'
    GOES_ON = 'it goes on'
    REFUSED_SOON = 'it is refused; the reason follows'
    ANSWERED = 'the line is, or may be, its answer'


class Begins(Enum):
    """Why the robot sets out, if no command under way asked for it."""

    LATE = 'for a drive of ours whose command has ended for its giver'
    ITSELF = 'by itself'
    OTHERS = 'for another client'


Found = Union[bool, Sequence[Execution]]  # whether a row holds, or the commands concerned
Find = Callable[[CommandQueue, Any], Found]


@dataclass(frozen=True)
class Row:
    """A row of the table: what lines of these kinds mean for the commands that `find` returns."""

    name: str
    lines: Tuple[Type[Reply], ...]  # empty: all
    find: Find
    meaning: Union[Outcome, Means, StopOf, Begins]
    source: str


class Attribution:
    """Assigns the robot's lines to the commands of a queue."""

    def __init__(self, commands: CommandQueue) -> None:
        self._commands = commands

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """Processes a line of the robot. `reply` is the parsed line, `text` the line itself."""
        records = self._commands.records
        for row, stops in self._decide(LinePart.HALT, reply):
            for stop in stops:
                self._commands.add_line(stop, text, now)
            records.begins_to_stop(StopOf(row.meaning))
        records.said(reply)
        ended = _ended_drives(self._commands, reply)
        for row, _ in self._decide(LinePart.ENDED, reply):
            records.ended_late(ended, Outcome(row.meaning), text)
            return
        claimed = self._apply(LinePart.COMMAND, reply, text, now)
        if records.heard.sets_out and not claimed:
            for row, _ in self._decide(LinePart.START, reply):
                self._starts(Begins(row.meaning), activity_of(reply), text)
        for execution in claimed:
            self._refused(execution)
        answered = self._apply(LinePart.ANSWER, reply, text, now, bool(claimed))
        self._activity(reply, text, now, answered)

    def _decide(self, part: LinePart, reply: Reply, claimed: bool = False
                ) -> Iterable[Tuple[Row, Sequence[Execution]]]:
        """Returns the first row of this part that holds, and the commands to which the line
        belongs. Returns nothing if no row holds.
        """
        for row in ATTRIBUTIONS[part]:
            if row.lines and type(reply) not in row.lines or (
                    claimed and row.meaning is Means.ANSWERED):
                continue
            found = row.find(self._commands, reply)
            if found:
                return [(row, () if isinstance(found, bool) else found)]
        return []

    def _apply(self, part: LinePart, reply: Reply, text: str, now: float,
               claimed: bool = False) -> Sequence[Execution]:
        """Applies the row to the commands to which the line belongs, and returns these commands."""
        for row, executions in self._decide(part, reply, claimed):
            for execution in executions:
                if isinstance(row.meaning, Outcome):
                    self._commands.add_line(execution, text, now)
                    self._commands.end(execution, row.meaning, _reason(reply) or text)
                else:
                    _HANDLERS[Means(row.meaning)](self, execution, reply, text, now)
            return executions
        return ()

    def _acknowledged(self, execution: Execution, reply: Reply, text: str, now: float) -> None:
        self._commands.add_line(execution, text, now)
        self._commands.begin(execution, text)

    def _continued(self, execution: Execution, reply: Reply, text: str, now: float) -> None:
        """Handles a line about a drive. A line that shows a standing robot is no sign of life of a
        drive that has begun.

        Some robots name their dock as a goal. On a drive to the dock, the first goal that the robot
        names is the dock; see `_leads_elsewhere`.
        """
        activity = activity_of(reply)
        before, to_goal = execution.progress.shown_when_sent, activity.kind is _TO_GOAL
        to_dock = to_goal and execution.command.spec.course is DriveCourse.INTO_THE_DOCK
        if before is not None and before.kind in STANDING and (
                to_dock or activity.kind in ABOUT_THE_DOCK):
            execution.progress.set_out = True
        if to_goal:
            execution.progress.dock_name = activity.goal.casefold()
        has_begun = execution in self._commands.begun_drives
        if self._commands.records.heard.sets_out and not has_begun:
            execution.progress.seemed_to_begin = text
        stands = has_begun and activity.kind in STANDING
        self._commands.add_line(execution, text, now, sign_of_life=not stands)

    def _refused_soon(self, execution: Execution, reply: Reply, text: str, now: float) -> None:
        execution.progress.rejected_at = now
        self._commands.add_line(execution, text, now)

    def _answered(self, execution: Execution, reply: Reply, text: str, now: float) -> None:
        self._commands.add_line(execution, text, now)

    def _refused(self, execution: Execution) -> None:
        """Handles the refusal of a drive for which the robot seemed to set out.

        In fact the robot has set out for another client. Nothing is noted if the robot has halted
        since then.
        """
        text, shown = execution.progress.seemed_to_begin, self._commands.records.heard.activity
        is_refused = execution.result is not None and execution.result.outcome in REFUSED
        if text and is_refused and shown is not None and shown.kind not in HALTED:
            self._starts(Begins.OTHERS, activity_of(parse_line(text)), text)

    def _starts(self, why: Begins, activity: Activity, text: str) -> None:
        """Notes that the robot obeys something else now. Our commands that it obeyed have ended.

        Our stop has also ended if the robot has said `Stopping` for it. If the robot has not, or if
        a drive before the stop is still to come, the robot may still have to obey our stop: the
        next `Stopping` may be for a stop of another client.
        """
        records = self._commands.records
        if why is Begins.LATE:
            records.begins_late(activity, text)
        else:
            records.driven_by_others(
                MotionCause.ROBOT if why is Begins.ITSELF else MotionCause.OTHER_CLIENT,
                activity, text)
        for execution in [e for e in self._commands.motion_executions if records.has_begun(e)
                          and not (e.command.spec.stops and records.waits_for_a_drive(e))]:
            self._commands.end_before(execution, f'taken over: {text}')
            self._commands.end(execution, Outcome.INTERRUPTED, f'taken over: {text}')

    def _activity(self, reply: Reply, text: str, now: float, asked: Sequence[Execution]) -> None:
        """Notes what the robot does, if the line shows it.

        asked -- the queries that a status answers
        """
        if isinstance(reply, (replies.StatusText, replies.OneLineStatus)):
            shown = reply.text if isinstance(reply, replies.StatusText) else reply.status
            if shown:
                seen = Observation(
                    read_activity(shown), shown, True, asked[0].order if asked else None)
                self._observe(seen, now)
                self._commands.records.showed(seen.activity, shown, seen.asked)
        elif activity_of(reply).kind is not ActivityKind.UNKNOWN:
            self._observe(Observation(activity_of(reply), text, False), now)

    def _observe(self, seen: Observation, now: float) -> None:
        for drive in self._commands.records.observed(seen, now):
            if seen.activity.kind is ActivityKind.GOING_TO_POINT:
                drive.progress.points.add(seen.point)
            if seen.is_status:
                drive.progress.heard = now
                if acknowledges(drive, seen.activity.reply):
                    self._commands.begin(drive, seen.words)


_HANDLERS: Mapping[Means, Callable[[Attribution, Execution, Reply, str, float], None]] = {
    Means.ACKNOWLEDGED: Attribution._acknowledged, Means.GOES_ON: Attribution._continued,
    Means.REFUSED_SOON: Attribution._refused_soon, Means.ANSWERED: Attribution._answered}


def _reason(reply: Reply) -> str:
    """Returns the robot's reason if it is only a part of the line, otherwise an empty text."""
    if isinstance(reply, (replies.CommandErrorDescription, replies.SetUpError,
                          replies.RobotError)):
        return reply.text
    return ''


# --- the commands that a line may be about --------------------------------------------------------

Scope = Callable[[CommandQueue], Sequence[Execution]]


def _first(scope: Scope, fits: Callable[[Execution, Any], object]) -> Find:
    """Returns a function that finds the first command of a scope that fits the line."""
    return lambda commands, reply: [e for e in scope(commands) if fits(e, reply)][:1]


def _sent(commands: CommandQueue) -> Sequence[Execution]:
    return commands.sent


def _drives(commands: CommandQueue) -> Sequence[Execution]:
    return commands.drives


def _begun(commands: CommandQueue) -> Sequence[Execution]:
    return commands.begun_drives


def _others(commands: CommandQueue) -> Sequence[Execution]:
    """Returns the queries and stops that were sent."""
    return [e for e in commands.sent if not e.command.spec.drives]


def _queries(commands: CommandQueue) -> Sequence[Execution]:
    return [e for e in _others(commands) if not e.command.spec.stops]


def _not_begun(commands: CommandQueue) -> List[Execution]:
    """Returns the commands that the robot has not acknowledged or begun to answer."""
    return [e for e in commands.sent if not commands.records.has_begun(e)]


def _not_refused(commands: CommandQueue) -> List[Execution]:
    """Returns the commands of `_not_begun` for which no `CommandError` has come."""
    return [e for e in _not_begun(commands) if e.progress.rejected_at is None]


def _fresh(commands: CommandQueue) -> List[Execution]:
    """Returns the drives that the robot has not acknowledged, the oldest first."""
    return [e for e in _not_begun(commands) if e.command.spec.drives]


def _began(commands: CommandQueue) -> List[Execution]:
    """Returns the drives that the robot has acknowledged, the newest first.

    If the line begins a motion, drives that do not set out again are left out. These are the drives
    that something newer has replaced, such as a stop of another client. They are also all drives
    before a stop that the robot obeys, even if it has not said yet that they are over.
    """
    begun = commands.begun_drives[::-1]
    if not commands.records.heard.sets_out:
        return begun
    begun = [e for e in begun if not commands.records.is_replaced(e)]
    stops = [e.order for e in commands.motion_executions
             if e.command.spec.stops and commands.records.has_begun(e)]
    return [e for e in begun if e.order > max(stops, default=0)]


def _next(commands: CommandQueue) -> List[Execution]:
    """Returns the drives that the robot may acknowledge or complete now, the oldest first.

    The first drive about which the robot has said nothing comes next. A later drive is returned
    only if the robot's lines name its goal, route or task. If the robot docks for another client
    and only repeats this, it has not answered any of our drives.
    """
    if commands.records.heard.repeats and commands.records.drives_for_others:
        return []
    first = _first_unanswered(commands)
    return [e for e in _fresh(commands) if not commands.records.comes_earlier(e)
            and (e.order <= first or _is_named(e))]


def _is_named(execution: Execution) -> bool:
    """Returns whether the robot's lines about a drive name its goal, route or task."""
    command = execution.command
    return bool(command.goals or (
        command.arguments and command.spec.course is not DriveCourse.TO_A_PLACE))


def _first_unanswered(commands: CommandQueue) -> float:
    """Returns the number (`order`) of the oldest drive about which no line has come."""
    return next((e.order for e in _fresh(commands) if not e.has_lines), math.inf)


def _next_first(commands: CommandQueue) -> List[Execution]:
    return _next(commands) + _began(commands)


def _began_first(commands: CommandQueue) -> List[Execution]:
    return _began(commands) + _next(commands)


def _to_complete(commands: CommandQueue) -> List[Execution]:
    """Returns the drives that a line may complete.

    While the robot carries out a drive of another client, a line about a completion is about that
    drive. So our drives that the robot has not acknowledged are left out.
    """
    return _began(commands) if commands.records.drives_for_others else _began_first(commands)


def _present(commands: CommandQueue) -> Sequence[Execution]:
    """Returns the drive of ours that the robot carries out, otherwise our next drive.

    Empty: the robot carries out a drive of another client, or we have sent no drive.
    """
    return commands.begun_drives[-1:] or _to_come(commands)


def _to_come(commands: CommandQueue) -> Sequence[Execution]:
    return [] if commands.records.drives_for_others else commands.drives[:1]


def _refused(commands: CommandQueue) -> Sequence[Execution]:
    """Returns the oldest command for which a `CommandError` came, but not the reason yet."""
    return [e for e in commands.sent if e.progress.rejected_at is not None][:1]


def _unanswered(commands: CommandQueue) -> Sequence[Execution]:
    """Returns the newest unanswered command, for a line that names no command.

    Commands that are neither drives nor stops come first. A drive that is ended here by mistake
    would have no giver while the robot carries it out.
    """
    unanswered = [e for e in _not_begun(commands) if not e.progress.set_out]
    others = [e for e in unanswered if not (e.command.spec.drives or e.command.spec.stops)]
    return (others or unanswered)[-1:]


def _need_motors(commands: CommandQueue) -> Sequence[Execution]:
    """Returns the commands that end when the motors go off: drives and `enableMotors`.

    The robot resumes no drive by itself.
    """
    return [e for e in commands.sent
            if e.command.spec.drives or e.command.name == 'enableMotors']


def _obeyed_stops(commands: CommandQueue, reply: Reply) -> List[Execution]:
    """Returns the stops that a `Stopped` ends.

    The robot answers in the order of sending. If it has said nothing about a drive, it has not
    answered a stop after that drive either: an earlier stop or another client stopped the robot.
    If the robot never says anything about the drive, a doubt ends the stop later; see `drives`.
    """
    if not commands.records.heard.stopped_by_us:
        return []
    first = _first_unanswered(commands)
    return [e for e in commands.motion_executions if e.command.spec.stops and e.order < first
            and not commands.records.answers_a_drive_before(e)]


def _ended_drives(commands: CommandQueue, reply: Reply) -> Sequence[DriveRecord]:
    """Returns the drives that the line is about, if they have already ended for their givers.

    For a refusal, this is the drive that the refusal names, if the robot has to answer it next. For
    `Interrupted`, these are the drives that may have caused the interrupted motion.
    """
    if isinstance(reply, replies.Interrupted):
        is_of_another = _first(_begun, _was_interrupted)(commands, reply)
        return [] if is_of_another else commands.records.lost_drives(activity_of(
            parse_line(reply.text)))
    if not isinstance(reply, replies.CommandError):
        return []
    try:
        command = parse_command(reply.command)
    except InvalidCommand:
        return []
    ended = commands.records.ended_drive(names_of(command), command.name)
    return [ended] if ended else []


# --- whether a line fits a command ----------------------------------------------------------------

def _any(execution: Execution, reply: Reply) -> bool:
    return True


def _completes(execution: Execution, reply: Reply) -> bool:
    return fits(execution.command.spec.completed_by, execution, reply)


def _aborts(execution: Execution, reply: Reply) -> bool:
    return fits(execution.command.spec.aborted_by, execution, reply)


def _continues(execution: Execution, reply: Reply) -> bool:
    return fits(execution.command.spec.related, execution, reply)


def _leads_elsewhere(execution: Execution, reply: Reply) -> bool:
    """Returns whether the robot drives to a goal that is not its dock, although it was sent to the
    dock; see `Attribution._continued`.
    """
    activity = activity_of(reply)
    return (execution.command.spec.course is DriveCourse.INTO_THE_DOCK
            and activity.kind is _TO_GOAL
            and activity.goal.casefold() != execution.progress.dock_name)


def _under_way(commands: CommandQueue, reply: Reply) -> Found:
    """Returns the drive that the line shows to be under way.

    A drive to the dock is left out while the robot drives to another goal. The robot may have to
    answer an ended drive next. If the line names the goal of such a drive, drives that are not
    acknowledged are left out.
    """
    elsewhere = [e for e in commands.begun_drives if _leads_elsewhere(e, reply)]
    goal = activity_of(reply).goal.casefold()
    is_late = goal and commands.records.ended_drive((goal,))
    drives = _began(commands) if is_late else _began_first(commands)
    return [e for e in drives if _continues(e, reply) and e not in elsewhere][:1]


def _may_be_answered(execution: Execution, reply: Reply) -> bool:
    return execution.command.spec.completed_by is None and type(reply) not in _NO_ANSWER


def _repeats(is_same: Callable[[str, str], bool]) -> Callable[[Execution, Any], bool]:
    """Returns a function that compares the command in a refusal with the line that was sent.

    Passwords in the robot's lines are redacted, so they are redacted in the sent lines as well.
    """
    return lambda execution, reply: is_same(
        _plain(reply.command),
        _plain(redact_passwords(execution.command.line).decode('utf-8', 'replace')))


def _repeats_its_name(execution: Execution, reply: replies.CommandError) -> bool:
    """Returns whether a refusal repeats the name of a command, and names no other goal or point.

    A refusal with another goal or point is the late answer to a command that has ended.
    """
    command, said = execution.command, _plain(reply.command).split()[1:]
    if not _repeats(lambda said, given: said.split()[:1] == given.split()[:1])(execution, reply):
        return False
    if command.goals and said:
        at = command.spec.goal_at or 0
        goals = [_plain(readable(goal)).split() for goal in command.goals]
        return any(said[at:at + len(goal)] == goal for goal in goals)
    point, own = coordinates(' '.join(said)), coordinates(' '.join(command.arguments[:len(said)]))
    return all(abs(one - other) <= _ROUNDED for one, other in zip(point, own))


def _plain(command: str) -> str:
    return ' '.join(command.replace('"', ' ').split()).casefold()


def _lacks_goal(execution: Execution, reply: replies.CommandErrorDescription) -> bool:
    return bool(_NO_GOAL.search(reply.text))


def _names_lacking_goal(execution: Execution, reply: replies.CommandErrorDescription) -> bool:
    return _lacks_goal(execution, reply) and any(
        re.search(rf'(?<!\w){re.escape(name)}(?!\w)', reply.text, re.IGNORECASE)
        for name in execution.command.goals)


def _goal_named(commands: CommandQueue, reply: replies.CommandErrorDescription) -> Found:
    return not _refused(commands) and _first(_not_begun, _names_lacking_goal)(commands, reply)


def _lacks_power(execution: Execution, reply: Any) -> bool:
    return execution.command.spec.drives and names_emergency_stop(reply.text)


def _is_unknown(execution: Execution, reply: replies.UnknownCommand) -> bool:
    said, given = _name(reply), execution.command.text.split(' ', 1)[0].lower()
    return bool(said) and (given == said or len(said) >= _CUT_NAME and given.startswith(said))


def _name(reply: replies.UnknownCommand) -> str:
    return reply.name.strip(' "\':.').lower()


def _is_misused(execution: Execution, reply: replies.Usage) -> bool:
    return execution.command.name.lower() == reply.syntax.split(' ', 1)[0].lower()


def _was_interrupted(execution: Execution, reply: replies.Interrupted) -> bool:
    spec, ran = execution.command.spec, parse_line(reply.text)
    return (fits(spec.acknowledged_by, execution, ran) or fits(spec.related, execution, ran))


def _was_at_its_point(execution: Execution, reply: replies.Interrupted) -> bool:
    point = coordinates(getattr(parse_line(reply.text), 'goal', ''))
    return bool(point) and point in execution.progress.points


def _was_interrupted_in_words(execution: Execution, reply: replies.Interrupted) -> bool:
    ran = parse_line(reply.text)
    course = _IN_WORDS.get(activity_of(ran).kind)
    return isinstance(ran, replies.UnknownLine) or (
        course is not None and execution.command.spec.course is course)


def _is_for_it(execution: Execution, reply: replies.FailedGoingTo) -> bool:
    return execution.command.is_for(reply.goal)


def _names_no_goal(execution: Execution, reply: replies.FailedGoingTo) -> bool:
    return reply.goal.lower() in ('goal', 'point') or bool(coordinates(reply.goal))


def _fails_to_localize(execution: Execution, reply: replies.Failure) -> bool:
    return execution.command.name.startswith('localize') and bool(
        _ABOUT_LOCALIZING.search(reply.text))


def _loses_power(commands: CommandQueue, reply: replies.Motors) -> Found:
    """Returns the commands that end because the motors went off.

    A drive on its way does not end: it may reach the robot when the motors are on again.
    """
    begun = commands.begun_drives
    return [e for e in _need_motors(commands)
            if not reply.enabled and (e in begun or not e.command.spec.drives)]


def _fails_to_begin(commands: CommandQueue, reply: Any) -> Found:
    """Returns the drive that fails before it begins.

    If the robot has begun a drive, no drive is returned: the status decides about this drive.
    """
    about = _ABOUT_DRIVING.search(reply.text) and not commands.begun_drives
    return _to_come(commands) if about else []


# --- what the robot does --------------------------------------------------------------------------

def _stands_for_us(commands: CommandQueue, reply: Reply) -> Found:
    """Returns whether the robot says `Stopped` unexpectedly, and has sent no `Stopping` for our
    stop. If so, the last `Stopping` was for our stop, but was attributed to another cause.
    """
    heard = commands.records.heard
    return heard.will_not_stand and heard.unheard_stops > 0


def _stops_for_us(commands: CommandQueue, reply: Reply) -> Found:
    """Returns our oldest stop for which no `Stopping` has come.

    Returns True if this stop has already ended for its giver. Returns False if there is no such
    stop, or if another halt may come first: while the robot has to answer a drive before the stop,
    it may halt by itself (`SelfStop`), or because that drive replaces its motion.
    """
    records, heard = commands.records, commands.records.heard
    stops = [e for e in _not_begun(commands) if e.command.spec.stops]
    if not heard.unheard_stops or stops and (
            heard.stops_itself is not None and records.waits_for_a_drive(stops[0])
            or records.replaces_a_drive_before(stops[0])):
        return False
    return stops[:1] if len(stops) == heard.unheard_stops else True


def _stops_by_itself(why: SelfStop) -> Find:
    return lambda commands, reply: commands.records.heard.stops_itself is why


def _begins_late(commands: CommandQueue, reply: Reply) -> bool:
    return commands.records.may_begin_late(activity_of(reply))


def _docks_by_itself(commands: CommandQueue, reply: Reply) -> bool:
    return activity_of(reply).kind is ActivityKind.DOCKING and commands.records.is_idle


_HALTS = (replies.Stopping,)
_ANY: Tuple[Type[Reply], ...] = ()
_TABLE = 'the lines of each command stand in `command_table`'

ATTRIBUTIONS: Mapping[LinePart, Tuple[Row, ...]] = {
    LinePart.HALT: (
        Row('our stop', _HALTS, _stops_for_us, StopOf.US,
            'p. 242: `stop` is answered by `Stopping`, `Stopped`, once for each `stop`'),
        Row('undocked', _HALTS, _stops_by_itself(SelfStop.UNDOCKED), StopOf.ROBOT,
            'p. 245: `Stopping`, `Stopped` end undocking, possibly after the result'),
        Row('motors enabled', _HALTS, _stops_by_itself(SelfStop.MOTORS_ENABLED), StopOf.ROBOT,
            'p. 190: the pair follows `Motors enabled`'),
        Row('cleared fault', _HALTS, _stops_by_itself(SelfStop.FAULT_CLEARED),
            StopOf.CLEARED_FAULT, 'p. 66: clearing a fault prints `Stopping` alone'),
        Row('attempt to dock', _HALTS,
            lambda commands, reply: commands.records.is_about_the_dock, StopOf.ROBOT,
            'I617-E-02 p. 71: a robot that misses its dock stops, and tries again'),
        Row('replacement', _HALTS,
            lambda commands, reply: commands.records.replaces_a_drive, StopOf.REPLACEMENT,
            'assumed: some robots stop for an instant to replace a drive'),
        Row('our stop after all', (replies.Stopped,), _stands_for_us, StopOf.US,
            'p. 242: a robot that stands was stopped'),
        Row('stands unasked', (replies.Stopped,),
            lambda commands, reply: commands.records.heard.will_not_stand, StopOf.OTHERS,
            'p. 242: a robot that stands was stopped'),
        Row('stop of another client', _HALTS, lambda commands, reply: True, StopOf.OTHERS,
            'p. 46: all clients receive it')),
    LinePart.ENDED: (
        Row('refused late', (replies.CommandError,),
            lambda commands, reply: bool(_ended_drives(commands, reply)), Outcome.REJECTED,
            'p. 46: the line names the command'),
        Row('broken off late', (replies.Interrupted,),
            lambda commands, reply: bool(_ended_drives(commands, reply)), Outcome.INTERRUPTED,
            'p. 242: the line repeats the status of the motion')),
    LinePart.COMMAND: (
        # refusals
        Row('refused: whole line', (replies.CommandError,),
            _first(_not_refused, _repeats(str.__eq__)),
            Means.REFUSED_SOON, 'p. 46: the line is repeated, and a description follows'),
        Row('refused: beginning', (replies.CommandError,),
            _first(_not_refused, _repeats(
                lambda said, given: len(said) >= _CUT_NAME and given.startswith(said))),
            Means.REFUSED_SOON, 'observed: long names are cut'),
        Row('refused: name', (replies.CommandError,),
            _first(_not_refused, _repeats_its_name),
            Means.REFUSED_SOON, 'observed: arguments are left out or written otherwise'),
        Row('no goal', (replies.CommandErrorDescription,), _first(_refused, _lacks_goal),
            Outcome.NO_GOAL, 'p. 46: `No goal`'),
        Row('no goal of this name', (replies.CommandErrorDescription,), _goal_named,
            Outcome.NO_GOAL, 'observed: the description comes alone'),
        Row('no power', (replies.CommandErrorDescription,), _first(_refused, _lacks_power),
            Outcome.EMERGENCY_STOPPED, 'p. 87: `Estop pressed cannot enable motors`'),
        Row('refused', (replies.CommandErrorDescription,), _first(_refused, _any),
            Outcome.REJECTED, 'p. 46: the description follows the error'),
        Row('unknown command', (replies.UnknownCommand,), _first(_not_begun, _is_unknown),
            Outcome.UNKNOWN_COMMAND, 'observed: the name follows, cut after 16 characters'),
        Row('unknown command without a name', (replies.UnknownCommand,),
            _first(_unanswered, lambda execution, reply: not _name(reply)),
            Outcome.UNKNOWN_COMMAND, 'p. 44: `Unknown command`'),
        Row('not set up', (replies.SetUpError,), _first(_unanswered, _any), Outcome.REJECTED,
            'p. 46: names no command'),
        Row('usage', (replies.Usage,), _first(_not_begun, _is_misused), Outcome.REJECTED,
            'p. 44: a command that lacks arguments is answered by its syntax'),
        # failures and interruptions of drives
        Row('interrupted', (replies.Interrupted,), _first(_begun, _was_interrupted),
            Outcome.INTERRUPTED, 'p. 242: the line repeats the status of the motion'),
        Row('interrupted at its point', (replies.Interrupted,), _first(_begun, _was_at_its_point),
            Outcome.INTERRUPTED, 'I617-E-02 p. 243: the point of a goal instead of its name'),
        Row('interrupted in other words', (replies.Interrupted,),
            _first(lambda commands: commands.begun_drives[-1:], _was_interrupted_in_words),
            Outcome.INTERRUPTED, 'assumed: only what the robot does can be interrupted'),
        Row('emergency stop', (replies.EStop, replies.RobotError),
            lambda commands, reply: _need_motors(commands) if reply.pressed else [],
            Outcome.EMERGENCY_STOPPED, 'p. 190; p. 251: `Error: Emergency stop pressed`'),
        Row('error', (replies.RobotError,),
            lambda commands, reply: commands.begun_drives[-1:], Outcome.FAILED,
            'p. 251: an error while the robot drives names no command'),
        Row('failed going to a goal', (replies.FailedGoingTo,), _first(_drives, _is_for_it),
            Outcome.FAILED, 'observed'),
        Row('failed going', (replies.FailedGoingTo,), _first(_present, _names_no_goal),
            Outcome.FAILED, 'observed: `Failed going to goal`'),
        Row('failed to localize', (replies.Failure,), _first(_sent, _fails_to_localize),
            Outcome.FAILED, 'observed'),
        Row('failed to begin', (replies.Failure, replies.RobotError), _fails_to_begin,
            Outcome.FAILED,
            'p. 251: `Cannot find path`'),
        Row('motors disabled', (replies.Motors,), _loses_power, Outcome.FAILED, 'p. 191'),
        # drives
        Row('completed', _ANY, _first(_to_complete, _completes), Outcome.SUCCEEDED, _TABLE),
        Row('acknowledged', _ANY, _first(_next_first, acknowledges), Means.ACKNOWLEDGED, _TABLE),
        Row('broken off', _ANY, _first(_began, _aborts), Outcome.INTERRUPTED, _TABLE),
        Row('under way', _ANY, _under_way, Means.GOES_ON, _TABLE)),
    LinePart.START: (
        Row('late start', _ANY, _begins_late, Begins.LATE,
            'p. 46: the line names a goal of ours'),
        Row('docks by itself', _ANY, _docks_by_itself, Begins.ITSELF,
            'p. 81: a robot docks by itself when its battery is low'),
        Row('drive of another client', _ANY, lambda commands, reply: True, Begins.OTHERS,
            'observed: all clients receive it')),
    LinePart.ANSWER: (
        Row('stands', (replies.Stopped,), _obeyed_stops, Outcome.SUCCEEDED,
            'p. 242: one `Stopped` may follow several `stop`'),
        Row('answer', _ANY, _first(_queries, _completes), Outcome.SUCCEEDED, _TABLE),
        Row('part of an answer', _ANY, _first(_others, _continues), Means.GOES_ON, _TABLE),
        Row('answer that is not documented', _ANY, _first(_others, _may_be_answered),
            Means.ANSWERED, 'assumed: the answer follows its command')),
}
