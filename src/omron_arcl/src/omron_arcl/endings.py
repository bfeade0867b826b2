"""Refusals, failures and interruptions end commands; they have the same form for all commands.

Their words differ between robots and manuals, and not all of them name the command. A line whose
command is uncertain ends no command here: see `drive_watch`.
"""
from __future__ import annotations

import re
from typing import Any, Callable, Iterable, Mapping, Type

from omron_arcl.activity import ActivityKind, activity_of
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import Course
from omron_arcl.execution import Execution, Outcome
from omron_arcl.parser import parse_line
from omron_arcl.replies import driving, refusals, safety
from omron_arcl.replies.reply import Reply, UnknownLine, coordinates
from omron_arcl.secret import redact_passwords

_CUT_NAME = 16  # length to which the robot shortens the name of an unknown command
# Activities that some robots report with a word of their own instead of a docking state.
_IN_WORDS = {ActivityKind.DOCKING: Course.INTO_THE_DOCK,
             ActivityKind.UNDOCKING: Course.OUT_OF_THE_DOCK}

_NO_GOAL = re.compile(r'\bno (such )?goal\b|\bgoal\b.*\b(not found|not exist|unknown)\b|'
                      r'\b(unknown|invalid) goal\b', re.IGNORECASE)
_EMERGENCY_STOP = re.compile(r'e-?stop|emergency stop', re.IGNORECASE)
_ABOUT_DRIVING = re.compile(r'\b(path|goal|plan|route|drive|driving|reach|dock)\b', re.IGNORECASE)
_ABOUT_LOCALIZING = re.compile(r'locali[sz]', re.IGNORECASE)


class BadEndings:
    """Ends the commands of a queue that the robot refuses or breaks off."""

    def __init__(self, commands: CommandQueue) -> None:
        self._commands = commands

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """Processes a line of the robot: `reply` is its meaning, `text` its words."""
        handle = _HANDLERS.get(type(reply))
        if handle:
            handle(self, reply, text, now)

    def _end(self, execution: Execution, outcome: Outcome, text: str, now: float,
             words: str = '') -> None:
        """The line ends the command. `words`: the robot's reason, if it is not the whole line."""
        self._commands.add_line(execution, text, now)
        self._commands.end(execution, outcome, words or text)

    # --- refusals ---------------------------------------------------------------------------------

    def _on_command_error(self, reply: refusals.CommandError, text: str, now: float) -> None:
        """The robot repeats the refused line; the description follows, possibly after others.

        Passwords in the robot's lines are redacted, so they are also redacted in the sent lines
        for the comparison.
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
        """Ends the oldest refused command. A "no goal" text without an error before it ends the
        command whose goal it names."""
        rejected = [e for e in self._commands.sent if e.rejected_at is not None]
        no_goal = bool(_NO_GOAL.search(reply.text))
        if not rejected and no_goal:
            rejected = [e for e in self._commands.sent
                        if not e.begun and _mentions(reply.text, e.command.goals)]
        if rejected:
            self._end(rejected[0], Outcome.NO_GOAL if no_goal
                      else _why_refused(rejected[0], reply.text), text, now, reply.text)

    def _on_unknown_command(self, reply: refusals.UnknownCommand, text: str, now: float) -> None:
        said = reply.name.strip(' "\':.').lower()
        if not said:
            self._refuse_nameless(Outcome.UNKNOWN_COMMAND, text, now)
            return
        for execution in self._commands.sent:
            given = execution.command.text.split(' ', 1)[0].lower()
            if given == said or (len(said) >= _CUT_NAME and given.startswith(said)):
                self._end(execution, Outcome.UNKNOWN_COMMAND, text, now)
                return

    def _on_setup_error(self, reply: refusals.SetUpError, text: str, now: float) -> None:
        self._refuse_nameless(Outcome.REJECTED, text, now, reply.text)

    def _refuse_nameless(self, outcome: Outcome, text: str, now: float, words: str = '') -> None:
        """The line names no command: it refuses the newest one that the robot has not answered.

        A drive is the last choice: if the robot carries it out nevertheless, it must have a giver.
        """
        unanswered = [e for e in self._commands.sent if not (e.begun or e.set_out)]
        others = [e for e in unanswered if not (e.command.spec.drives or e.command.spec.stops)]
        for execution in (others or unanswered)[-1:]:
            self._end(execution, outcome, text, now, words)

    def _on_usage(self, reply: refusals.Usage, text: str, now: float) -> None:
        name = reply.syntax.split(' ', 1)[0].lower()
        for execution in self._commands.sent:
            if execution.command.name.lower() == name and not execution.begun:
                self._end(execution, Outcome.REJECTED, text, now)
                return

    # --- failures and interruptions of drives -----------------------------------------------------

    def _on_interrupted(self, reply: driving.Interrupted, text: str, now: float) -> None:
        """The line repeats the status text of the interrupted motion.

        If that text names no drive of ours, `drive_watch` decides. Some robots name the point
        instead of the goal (ARCL manual I617-E-02 p. 243).
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
        """The line names no command: it fails the present drive, or else the first one to come."""
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
        """A text without a fixed form. It ends no drive that has begun: `drive_watch` decides."""
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
        """Ends all drives: the robot does not resume a goal by itself after its motors were off."""
        for execution in list(self._commands.sent):
            if execution.command.spec.drives or execution.command.name == 'enableMotors':
                self._end(execution, outcome, text, now)


_HANDLERS: Mapping[Type[Reply], Callable[[BadEndings, Any, str, float], None]] = {
    refusals.CommandError: BadEndings._on_command_error,
    refusals.CommandErrorDescription: BadEndings._on_description,
    refusals.UnknownCommand: BadEndings._on_unknown_command,
    refusals.SetUpError: BadEndings._on_setup_error,
    refusals.Usage: BadEndings._on_usage,
    driving.Interrupted: BadEndings._on_interrupted,
    driving.RobotError: BadEndings._on_error,
    driving.FailedGoingTo: BadEndings._on_failed_going,
    driving.Failure: BadEndings._on_failure,
    safety.EStop: BadEndings._on_estop,
    safety.Motors: BadEndings._on_motors,
}


def _why_refused(execution: Execution, words: str) -> Outcome:
    if execution.command.spec.drives and _EMERGENCY_STOP.search(words):
        return Outcome.EMERGENCY_STOPPED
    return Outcome.REJECTED


def _plain(command: str) -> str:
    return ' '.join(command.replace('"', ' ').split()).casefold()


def _is_cut_from(said: str, given: str) -> bool:
    """Whether the robot repeats only the beginning of the command."""
    return len(said) >= _CUT_NAME and given.startswith(said)


def _mentions(text: str, names: Iterable[str]) -> bool:
    """Whether one of the names is in the text, as separate words."""
    return any(re.search(rf'(?<!\w){re.escape(name)}(?!\w)', text, re.IGNORECASE)
               for name in names)
