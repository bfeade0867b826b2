"""Which line of the robot belongs to which command, and what it means for it.

The robot answers in the order of sending, with lines that carry no id. So a line is offered to the
commands that were sent, and the specification of each tells whether it is its own. What goes wrong
is said in the same way for all commands, and read here.
"""
from __future__ import annotations

from typing import Callable, Dict, Optional, Type

from omron_arcl.command_queue import CommandQueue
from omron_arcl.execution import Execution, Outcome
from omron_arcl.parser import parse_line
from omron_arcl.replies import (
    configuration,
    driving,
    equipment,
    general,
    refusals,
    safety,
    site,
    status,
    tasks,
)
from omron_arcl.replies.reply import Reply, UnknownLine
from omron_arcl.secret import blank_configured

_CUT_NAME = 16  # characters to which the robot cuts an unknown command's name

# Said to everybody, or refusals: these never answer a command whose answer is not known.
_NO_ANSWER = frozenset((
    driving.DockingStatus, driving.GoingTo, driving.GoingToPoint, driving.ArrivedAt,
    driving.ArrivedAtPoint, driving.Parking, driving.Stopping, driving.Stopped,
    driving.Interrupted, driving.RobotError, safety.EStop, safety.Motors, tasks.WaitState,
    status.OneLineStatus, status.StatusText, equipment.RangeReading, equipment.ExternalIOUpdate,
    site.MapChanged, configuration.ConfigurationChanged, general.Notice, refusals.CommandError,
    refusals.CommandErrorDescription, refusals.UnknownCommand, refusals.SetUpError,
    refusals.Usage))

# The robot begins something new; unless a command of ours asked for it, another client did.
_SETTING_OUT = frozenset((driving.GoingTo, driving.GoingToPoint, driving.Patrolling,
                          tasks.ExecutingMacro, tasks.DoingTask))


class Attribution:
    """Gives the robot's lines to the commands of a queue."""

    def __init__(self, commands: CommandQueue) -> None:
        self._commands = commands
        self._docking: Optional[driving.DockingState] = None

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """A line came: what it means, and as it was said."""
        sets_out = self._sets_out(reply)
        if not self._commands.sent:
            return
        handle = _SPECIAL.get(type(reply))
        if handle:
            handle(self, reply, text, now)
        claimed = self._offer_to_drivers(reply, text, now, sets_out)
        if sets_out and not claimed:
            self._taken_over(text)
        self._offer_to_others(reply, text, now, claimed)

    # --- whose line it is -------------------------------------------------------------------------

    def _offer_to_drivers(self, reply: Reply, text: str, now: float, sets_out: bool) -> bool:
        """Whether a driving command claims the line.

        One that was stopped sets out no more, though the robot may not have said that it is over.
        """
        drivers = self._commands.drivers
        begun = [e for e in reversed(drivers) if e.begun]
        if sets_out:
            stops = [e.order for e in self._commands.sent if e.begun and e.command.name == 'stop']
            begun = [e for e in begun if e.order > max(stops, default=0)]
        fresh = [e for e in drivers if not e.begun]
        for execution in begun + fresh:
            spec, command = execution.command.spec, execution.command
            if spec.ends(command, reply):
                self._end(execution, Outcome.SUCCEEDED, text, now)
                return True
        for execution in fresh + begun:
            spec, command = execution.command.spec, execution.command
            if spec.begins(command, reply):
                self._commands.add_line(execution, text, now)
                if not execution.begun:
                    execution.begun = True
                    self._commands.end_before(execution, f'replaced by "{command.text}"')
                return True
        for execution in begun + fresh:
            spec, command = execution.command.spec, execution.command
            if execution.begun and spec.undone and spec.undone(command, reply):
                self._end(execution, Outcome.INTERRUPTED, text, now)
                return True
            if spec.belongs(command, reply):
                self._commands.add_line(execution, text, now)
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
            elif spec.ends is None:
                if not (claimed or type(reply) in _NO_ANSWER):
                    execution.begun = True
                    self._commands.add_line(execution, text, now)
                    return
            elif spec.ends(command, reply):
                self._end(execution, Outcome.SUCCEEDED, text, now)
                if command.name != 'stop':
                    return
                stopped = True
                self._commands.end_before(execution, text)
            elif spec.begins and not execution.begun and spec.begins(command, reply):
                execution.begun = True
                self._commands.add_line(execution, text, now)
                return
            elif spec.belongs and spec.belongs(command, reply):
                self._commands.add_line(execution, text, now)
                return

    def _sets_out(self, reply: Reply) -> bool:
        """Whether the robot begins something new; the docking state tells by its change only."""
        kind = type(reply)
        if kind is driving.DockingStatus:
            before, self._docking = self._docking, reply.docking
            return (reply.docking is driving.DockingState.DOCKING
                    and before not in (None, reply.docking))
        return kind in _SETTING_OUT

    def _taken_over(self, text: str) -> None:
        """The robot obeys somebody else: whatever of ours it had begun to obey is over.

        A stop is among that once the robot has said `Stopping`. Before, it may be still to come.
        """
        for execution in [e for e in self._commands.movers if e.begun]:
            self._commands.end_before(execution, f'taken over: {text}')
            self._commands.end(execution, Outcome.INTERRUPTED, f'taken over: {text}')

    def _end(self, execution: Execution, outcome: Outcome, text: str, now: float,
             words: str = '') -> None:
        """The line ends the command; `words` where they are not the whole line."""
        self._commands.add_line(execution, text, now)
        self._commands.end(execution, outcome, words or text)

    # --- what ends commands badly -----------------------------------------------------------------

    def _on_command_error(self, reply: refusals.CommandError, text: str, now: float) -> None:
        """The robot repeats the line; the description follows, perhaps after other lines.

        Passwords are blanked in what comes from the robot, so in what was sent they are too.
        """
        refused = _plain(reply.command)
        for execution in self._commands.sent:
            given = blank_configured(execution.command.text.encode('ascii')).decode('ascii')
            if _plain(given) == refused and not (execution.rejected or execution.begun):
                execution.rejected = True
                self._commands.add_line(execution, text, now)
                return

    def _on_description(self, reply: refusals.CommandErrorDescription, text: str,
                        now: float) -> None:
        for execution in self._commands.sent:
            if execution.rejected:
                no_goal = reply.text.lower().startswith('no goal')
                self._end(execution, Outcome.NO_GOAL if no_goal else Outcome.REJECTED, text, now,
                          reply.text)
                return

    def _on_unknown_command(self, reply: refusals.UnknownCommand, text: str, now: float) -> None:
        said = reply.name.strip().lower()
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

    def _on_interrupted(self, reply: driving.Interrupted, text: str, now: float) -> None:
        ran = parse_line(reply.text)
        begun = [e for e in self._commands.drivers if e.begun]
        for execution in begun:
            spec, command = execution.command.spec, execution.command
            if spec.begins(command, ran) or spec.belongs(command, ran):
                break
        else:
            if not begun or not isinstance(ran, UnknownLine):
                return
            execution = begun[-1]
        self._end(execution, Outcome.INTERRUPTED, text, now)

    def _on_error(self, reply: driving.RobotError, text: str, now: float) -> None:
        """It names no command: what drives, or else what was to drive first, has failed."""
        drivers = self._commands.drivers
        if drivers:
            begun = [e for e in drivers if e.begun]
            self._end(begun[-1] if begun else drivers[0], Outcome.FAILED, text, now, reply.text)

    def _on_failed_going(self, reply: driving.FailedGoingTo, text: str, now: float) -> None:
        for execution in self._commands.drivers:
            if execution.command.is_for(reply.goal):
                self._end(execution, Outcome.FAILED, text, now)
                return

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

    def _on_status(self, reply: Reply, text: str, now: float) -> None:
        """A status that tells of the drive is a sign of life from it, though no line of its own."""
        begun = [execution for execution in self._commands.drivers if execution.begun]
        if begun:
            doing = parse_line(
                reply.status if isinstance(reply, status.OneLineStatus) else reply.text)
        for execution in begun:
            if execution.command.spec.begins(execution.command, doing):
                execution.heard = now


_SPECIAL: Dict[Type[Reply], Callable[[Attribution, Reply, str, float], None]] = {
    refusals.CommandError: Attribution._on_command_error,
    refusals.CommandErrorDescription: Attribution._on_description,
    refusals.UnknownCommand: Attribution._on_unknown_command,
    refusals.SetUpError: Attribution._on_setup_error,
    refusals.Usage: Attribution._on_usage,
    driving.Interrupted: Attribution._on_interrupted,
    driving.RobotError: Attribution._on_error,
    driving.FailedGoingTo: Attribution._on_failed_going,
    safety.EStop: Attribution._on_estop,
    safety.Motors: Attribution._on_motors,
    status.OneLineStatus: Attribution._on_status,
    status.StatusText: Attribution._on_status,
}


def _plain(command: str) -> str:
    return ' '.join(command.split()).casefold()
