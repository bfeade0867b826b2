"""Which line of the robot belongs to which command, and what it means for it.

The robot answers in the order of sending, with lines that carry no id. So a line is offered to the
commands that were sent, and the specification of each tells whether it is its own. What goes wrong
is said in the same way for all commands, and read here. This is the one place where it is decided
whose line it is: whoever wants a command done waits for its `Execution`.
"""
from __future__ import annotations

import re
from typing import Any, Callable, Mapping, Optional, Type

from omron_arcl.activity import STANDING, ActivityKind, activity_of, read_activity
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import Course
from omron_arcl.drive_watch import DriveWatch, Observation
from omron_arcl.execution import Execution, Outcome
from omron_arcl.parser import parse_line
from omron_arcl.replies import driving, equipment, general, refusals, safety, site, status, tasks
from omron_arcl.replies.reply import Reply, UnknownLine, coordinates
from omron_arcl.secret import redact_passwords

_CUT_NAME = 16  # characters to which the robot cuts an unknown command's name

# Said to everybody, or refusals: these never answer a command whose answer is not known.
_NO_ANSWER = frozenset((
    driving.DockingStatus, driving.GoingTo, driving.GoingToPoint, driving.ArrivedAt,
    driving.ArrivedAtPoint, driving.Parking, driving.Stopping, driving.Stopped,
    driving.Interrupted, driving.RobotError, driving.Failure, safety.EStop, safety.Motors,
    tasks.WaitState, status.OneLineStatus, status.StatusText, equipment.RangeReading,
    equipment.ExternalIOUpdate, site.MapChanged, site.ConfigurationChanged, general.Notice,
    refusals.CommandError, refusals.CommandErrorDescription, refusals.UnknownCommand,
    refusals.SetUpError, refusals.Usage))

# The robot begins something new; unless a command of ours asked for it, another client did.
_SETTING_OUT = frozenset((driving.GoingTo, driving.GoingToPoint, driving.Patrolling,
                          tasks.ExecutingMacro, tasks.DoingTask))

# What some robots say in a word of their own instead of a docking state.
_IN_WORDS = {ActivityKind.DOCKING: Course.INTO_THE_DOCK,
             ActivityKind.UNDOCKING: Course.OUT_OF_THE_DOCK}

_NO_GOAL = re.compile(r'\bno (such )?goal\b|\bgoal\b.*\b(not found|not exist|unknown)\b|'
                      r'\b(unknown|invalid) goal\b', re.IGNORECASE)
_EMERGENCY_STOP = re.compile(r'e-?stop|emergency stop', re.IGNORECASE)
_ABOUT_DRIVING = re.compile(r'\b(path|goal|plan|route|drive|driving|reach|dock)\b', re.IGNORECASE)
_ABOUT_LOCALIZING = re.compile(r'locali[sz]', re.IGNORECASE)


class Attribution:
    """Gives the robot's lines to the commands of a queue."""

    def __init__(self, commands: CommandQueue) -> None:
        self._commands = commands
        self.watch = DriveWatch(commands)
        self._docking: Optional[driving.DockingState] = None

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """A line came: what it means, and as it was said."""
        sets_out = self._sets_out(reply)
        if self._commands.sent:
            handle = _SPECIAL.get(type(reply))
            if handle:
                handle(self, reply, text, now)
            claimed = self._offer_to_drives(reply, text, now, sets_out)
            if sets_out and not claimed:
                self._taken_over(text)
            self._offer_to_others(reply, text, now, claimed)
        self._watch(reply, text, now)

    def _watch(self, reply: Reply, text: str, now: float) -> None:
        if isinstance(reply, (status.StatusText, status.OneLineStatus)):
            shown = reply.text if isinstance(reply, status.StatusText) else reply.status
            if shown:
                self.watch.observe(Observation(read_activity(shown), shown, True), now)
        elif self._commands.motion_executions:
            activity = activity_of(reply)
            if activity.kind is not ActivityKind.UNKNOWN:
                self.watch.observe(Observation(activity, text, False), now)

    # --- whose line it is -------------------------------------------------------------------------

    def _offer_to_drives(self, reply: Reply, text: str, now: float, sets_out: bool) -> bool:
        """Whether a driving command claims the line.

        One that was stopped sets out no more, though the robot may not have said that it is over.
        """
        drives = self._commands.drives
        begun = [e for e in reversed(drives) if e.begun]
        if sets_out:
            stops = [e.order for e in self._commands.sent if e.begun and e.command.spec.stops]
            begun = [e for e in begun if e.order > max(stops, default=0)]
        fresh = [e for e in drives if not e.begun]
        for execution in begun + fresh:
            spec, command = execution.command.spec, execution.command
            if spec.completed_by and spec.completed_by(command, reply):
                self._end(execution, Outcome.SUCCEEDED, text, now)
                return True
        for execution in fresh + begun:
            spec, command = execution.command.spec, execution.command
            if spec.acknowledged_by and spec.acknowledged_by(command, reply):
                self._commands.add_line(execution, text, now)
                self._commands.begin(execution)
                return True
        for execution in begun + fresh:
            spec, command = execution.command.spec, execution.command
            if execution.begun and spec.aborted_by and spec.aborted_by(command, reply):
                self._end(execution, Outcome.INTERRUPTED, text, now)
                return True
            if spec.related and spec.related(command, reply):
                stands = execution.begun and activity_of(reply).kind in STANDING
                self._commands.add_line(execution, text, now, sign_of_life=not stands)
                return True
        return False

    def _offer_to_others(self, reply: Reply, text: str, now: float, claimed: bool) -> None:
        """Gives the line to the first of the queries and stops that claims it.

        A `Stopped` ends every stop that was sent before the next driving command.
        """
        stopped = False
        for execution in list(self._commands.sent):
            spec, command = execution.command.spec, execution.command
            if spec.drives:
                if stopped:
                    return  # the stops behind it are still to come
            elif spec.completed_by is None:
                if not (claimed or type(reply) in _NO_ANSWER):
                    execution.begun = True
                    self._commands.add_line(execution, text, now)
                    return
            elif spec.completed_by(command, reply):
                self._end(execution, Outcome.SUCCEEDED, text, now)
                if not spec.stops:
                    return
                stopped = True
                self._commands.end_before(execution, text)
            elif (spec.acknowledged_by and not execution.begun
                    and spec.acknowledged_by(command, reply)):
                self._commands.add_line(execution, text, now)
                self._commands.begin(execution)
                return
            elif spec.related and spec.related(command, reply):
                self._commands.add_line(execution, text, now)
                return

    def _sets_out(self, reply: Reply) -> bool:
        """Whether the robot begins something new; the docking state tells by its change only."""
        if isinstance(reply, driving.DockingStatus):
            before, self._docking = self._docking, reply.docking
            return (reply.docking is driving.DockingState.DOCKING
                    and before not in (None, reply.docking))
        return type(reply) in _SETTING_OUT

    def _taken_over(self, text: str) -> None:
        """The robot obeys somebody else: whatever of ours it had begun to obey is over.

        A stop is among that once the robot has said `Stopping`. Before, it may be still to come.
        """
        for execution in [e for e in self._commands.motion_executions if e.begun]:
            self._commands.end_before(execution, f'taken over: {text}')
            self._commands.end(execution, Outcome.INTERRUPTED, f'taken over: {text}')

    def _end(self, execution: Execution, outcome: Outcome, text: str, now: float,
             words: str = '') -> None:
        """The line ends the command; `words` where they are not the whole line."""
        self._commands.add_line(execution, text, now)
        self._commands.end(execution, outcome, words or text)

    # --- refusals ---------------------------------------------------------------------------------

    def _on_command_error(self, reply: refusals.CommandError, text: str, now: float) -> None:
        """The robot repeats the line; the description follows, perhaps after other lines.

        Passwords are blanked in what comes from the robot, so in what was sent they are too.
        """
        open_to_it = [e for e in self._commands.sent if not e.begun and e.rejected_at is None]
        refused = _plain(reply.command)
        given = {id(e): _plain(redact_passwords(e.command.line).decode('utf-8', 'replace'))
                 for e in open_to_it}
        same = ([e for e in open_to_it if given[id(e)] == refused]
                or [e for e in open_to_it if _is_cut_from(refused, given[id(e)])]
                or [e for e in open_to_it if given[id(e)].split()[:1] == refused.split()[:1]][:1])
        if same:
            same[0].rejected_at = now
            self._commands.add_line(same[0], text, now)

    def _on_description(self, reply: refusals.CommandErrorDescription, text: str,
                        now: float) -> None:
        """Of the oldest refused; one that comes without an error, of that whose goal it names."""
        rejected = [e for e in self._commands.sent if e.rejected_at is not None]
        no_goal = bool(_NO_GOAL.search(reply.text))
        if not rejected and no_goal:
            rejected = [e for e in self._commands.sent
                        if not e.begun and _mentions(reply.text, e.command.goals)]
        if rejected:
            self._end(rejected[0], Outcome.NO_GOAL if no_goal else Outcome.REJECTED, text, now,
                      reply.text)

    def _on_unknown_command(self, reply: refusals.UnknownCommand, text: str, now: float) -> None:
        said = reply.name.strip(' "\':.').lower()
        for execution in self._commands.sent:
            given = execution.command.text.split(' ', 1)[0].lower()
            if given == said or (len(said) >= _CUT_NAME and given.startswith(said)) or not said:
                self._end(execution, Outcome.UNKNOWN_COMMAND, text, now)
                return

    def _on_setup_error(self, reply: refusals.SetUpError, text: str, now: float) -> None:
        """It names no command: the oldest that can still be refused is meant."""
        for execution in self._commands.sent:
            if not execution.begun:
                self._end(execution, Outcome.REJECTED, text, now, reply.text)
                return

    def _on_usage(self, reply: refusals.Usage, text: str, now: float) -> None:
        name = reply.syntax.split(' ', 1)[0].lower()
        for execution in self._commands.sent:
            if execution.command.name.lower() == name and not execution.begun:
                self._end(execution, Outcome.REJECTED, text, now)
                return

    # --- what ends drives badly -------------------------------------------------------------------

    def _on_interrupted(self, reply: driving.Interrupted, text: str, now: float) -> None:
        """It tells the status text of what ran; where that names no drive of ours, see the watch.

        Some robots name the point instead of the goal (ARCL manual I617-E-02 p. 243).
        """
        ran = parse_line(reply.text)
        point = coordinates(getattr(ran, 'goal', ''))
        begun = self._commands.begun_drives
        for execution in begun:
            spec, command = execution.command.spec, execution.command
            if (spec.acknowledged_by and spec.acknowledged_by(command, ran)
                    or spec.related and spec.related(command, ran)
                    or point and point in execution.points):
                self._end(execution, Outcome.INTERRUPTED, text, now)
                return
        kind = activity_of(ran).kind
        if begun and (isinstance(ran, UnknownLine)
                      or begun[-1].command.spec.course is _IN_WORDS.get(kind, False)):
            self._end(begun[-1], Outcome.INTERRUPTED, text, now)

    def _on_error(self, reply: driving.RobotError, text: str, now: float) -> None:
        """It names no command: what drives, or else what was to drive first, has failed."""
        if _EMERGENCY_STOP.search(reply.text):
            self._end_powerless(Outcome.EMERGENCY_STOPPED, text, now)
        else:
            self._fail_a_drive(text, now, reply.text)

    def _on_failed_going(self, reply: driving.FailedGoingTo, text: str, now: float) -> None:
        for execution in self._commands.drives:
            if execution.command.is_for(reply.goal):
                self._end(execution, Outcome.FAILED, text, now)
                return
        if reply.goal.lower() in ('goal', 'point') or coordinates(reply.goal):
            self._fail_a_drive(text, now)

    def _on_failure(self, reply: driving.Failure, text: str, now: float) -> None:
        """Free words: of a drive that has begun they end none at once, see the watch."""
        localizing = [e for e in self._commands.sent if e.command.name.startswith('localize')]
        if localizing and _ABOUT_LOCALIZING.search(reply.text):
            self._end(localizing[0], Outcome.FAILED, text, now)
        elif _ABOUT_DRIVING.search(reply.text) and not self._commands.begun_drives:
            self._fail_a_drive(text, now)

    def _fail_a_drive(self, text: str, now: float, words: str = '') -> None:
        drives = self._commands.begun_drives[-1:] or self._commands.drives[:1]
        if drives:
            self._end(drives[0], Outcome.FAILED, text, now, words)

    def _on_estop(self, reply: safety.EStop, text: str, now: float) -> None:
        if reply.pressed:
            self._end_powerless(Outcome.EMERGENCY_STOPPED, text, now)

    def _on_motors(self, reply: safety.Motors, text: str, now: float) -> None:
        if not reply.enabled:
            self._end_powerless(Outcome.FAILED, text, now)

    def _end_powerless(self, outcome: Outcome, text: str, now: float) -> None:
        """Without motors nothing drives, and the robot takes no goal up again by itself."""
        for execution in list(self._commands.sent):
            if execution.command.spec.drives or execution.command.name == 'enableMotors':
                self._end(execution, outcome, text, now)


_SPECIAL: Mapping[Type[Reply], Callable[[Attribution, Any, str, float], None]] = {
    refusals.CommandError: Attribution._on_command_error,
    refusals.CommandErrorDescription: Attribution._on_description,
    refusals.UnknownCommand: Attribution._on_unknown_command,
    refusals.SetUpError: Attribution._on_setup_error,
    refusals.Usage: Attribution._on_usage,
    driving.Interrupted: Attribution._on_interrupted,
    driving.RobotError: Attribution._on_error,
    driving.FailedGoingTo: Attribution._on_failed_going,
    driving.Failure: Attribution._on_failure,
    safety.EStop: Attribution._on_estop,
    safety.Motors: Attribution._on_motors,
}


def _plain(command: str) -> str:
    return ' '.join(command.replace('"', ' ').split()).casefold()


def _is_cut_from(said: str, given: str) -> bool:
    """Whether the robot repeats only the beginning of what it was given."""
    return len(said) >= _CUT_NAME and given.startswith(said)


def _mentions(text: str, names: Any) -> bool:
    """Whether one of the names stands in the text, as words of their own."""
    return any(re.search(rf'(?<!\w){re.escape(name)}(?!\w)', text, re.IGNORECASE)
               for name in names)
