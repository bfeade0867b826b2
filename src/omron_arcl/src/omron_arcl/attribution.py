"""Decides which command a line of the robot belongs to, and what the line means for it.

The robot answers in the order of sending, and its lines carry no id. Each line is therefore offered
to the commands that were sent; the specification of a command says whether the line belongs to it.
`endings` reads failures and refusals, `drive_watch` the robot's activity. Only this module decides
on the owner of a line. A program that needs the result of a command waits for its `Execution`.
"""
from __future__ import annotations

from typing import Optional

from omron_arcl.activity import STANDING, ActivityKind, activity_of, read_activity
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import Course
from omron_arcl.drive_watch import ABOUT_THE_DOCK, DriveWatch, Observation
from omron_arcl.endings import BadEndings
from omron_arcl.execution import Execution, Outcome
from omron_arcl.replies import driving, equipment, general, refusals, safety, site, status, tasks
from omron_arcl.replies.reply import Reply

# Lines to all clients, and refusals. They never answer a command whose answer is not documented.
_NO_ANSWER = frozenset((
    driving.DockingStatus, driving.GoingTo, driving.GoingToPoint, driving.ArrivedAt,
    driving.ArrivedAtPoint, driving.Parking, driving.Stopping, driving.Stopped,
    driving.Interrupted, driving.RobotError, driving.Failure, safety.EStop, safety.Motors,
    tasks.WaitState, status.OneLineStatus, status.StatusText, equipment.RangeReading,
    equipment.ExternalIOUpdate, site.MapChanged, site.ConfigurationChanged, general.Notice,
    refusals.CommandError, refusals.CommandErrorDescription, refusals.UnknownCommand,
    refusals.SetUpError, refusals.Usage))

# The robot begins a new motion. If no command of ours asked for it, another client did.
_SETTING_OUT = frozenset((driving.GoingTo, driving.GoingToPoint, driving.Patrolling,
                          tasks.ExecutingMacro, tasks.DoingTask))


class Attribution:
    """Assigns the robot's lines to the commands of a queue."""

    def __init__(self, commands: CommandQueue) -> None:
        self._commands = commands
        self.watch = DriveWatch(commands)
        self._bad_endings = BadEndings(commands)
        self._docking: Optional[driving.DockingState] = None

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """Processes a line of the robot: `reply` is its meaning, `text` its words."""
        sets_out = self._sets_out(reply)
        records = self._commands.records
        records.said(reply)
        if self._commands.sent:
            self._bad_endings.on_reply(reply, text, now)
        claimed = self._offer_to_drives(reply, text, now, sets_out)
        if sets_out and not claimed:
            records.set_out(reply, text)
            self._taken_over(text)
        self._offer_to_others(reply, text, now, claimed)
        self._watch(reply, text, now)

    def _watch(self, reply: Reply, text: str, now: float) -> None:
        if isinstance(reply, (status.StatusText, status.OneLineStatus)):
            shown = reply.text if isinstance(reply, status.StatusText) else reply.status
            if shown:
                self.watch.observe(Observation(read_activity(shown), shown, True), now)
                self._commands.records.showed(read_activity(shown), shown)
        elif self._commands.motion_executions:
            activity = activity_of(reply)
            if activity.kind is not ActivityKind.UNKNOWN:
                self.watch.observe(Observation(activity, text, False), now)

    # --- the owner of a line ----------------------------------------------------------------------

    def _offer_to_drives(self, reply: Reply, text: str, now: float, sets_out: bool) -> bool:
        """Whether a driving command claims the line.

        A drive that was sent before a stop does not set out again, even if the robot has not yet
        said that the drive is over.
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
            if spec.related and spec.related(command, reply) and not _leads_elsewhere(
                    execution, reply):
                kind = activity_of(reply).kind
                stands = execution.begun and kind in STANDING
                if kind in ABOUT_THE_DOCK and (
                        read_activity(execution.shown_when_sent).kind in STANDING):
                    execution.set_out = True
                self._commands.add_line(execution, text, now, sign_of_life=not stands)
                return True
        return False

    def _offer_to_others(self, reply: Reply, text: str, now: float, claimed: bool) -> None:
        """Gives the line to the first query or stop that claims it.

        A `Stopped` ends every stop that was sent before the next driving command.
        """
        stopped = False
        for execution in list(self._commands.sent):
            spec, command = execution.command.spec, execution.command
            if spec.drives:
                if stopped:
                    return  # the stops behind this drive are not obeyed yet
            elif spec.completed_by is None:
                if not (claimed or type(reply) in _NO_ANSWER):
                    execution.begun = True
                    self._commands.add_line(execution, text, now)
                    return
            elif spec.completed_by(command, reply):
                if spec.stops and not self._commands.records.stopped_by_us:
                    return  # another client's stop ends before ours
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
        """Whether the robot begins a new motion; a docking state counts only when it changes."""
        if isinstance(reply, driving.DockingStatus):
            before, self._docking = self._docking, reply.docking
            return (reply.docking is driving.DockingState.DOCKING
                    and before not in (None, reply.docking))
        return type(reply) in _SETTING_OUT

    def _taken_over(self, text: str) -> None:
        """The robot obeys another client, so the commands of ours that it obeyed are over.

        This includes a stop after which the robot has said `Stopping`. Without that line the robot
        may still have to obey the stop.
        """
        for execution in [e for e in self._commands.motion_executions if e.begun]:
            self._commands.end_before(execution, f'taken over: {text}')
            self._commands.end(execution, Outcome.INTERRUPTED, f'taken over: {text}')

    def _end(self, execution: Execution, outcome: Outcome, text: str, now: float) -> None:
        """The line ends the command."""
        self._commands.add_line(execution, text, now)
        self._commands.end(execution, outcome, text)


def _leads_elsewhere(execution: Execution, reply: Reply) -> bool:
    """Whether the robot drives to a goal that is not its dock.

    Some robots name their dock as a goal. The name with which the robot sets out is that of its
    dock; once it docks, no other name can be.
    """
    if (execution.command.spec.course is not Course.INTO_THE_DOCK
            or activity_of(reply).kind is not ActivityKind.GOING_TO_GOAL):
        return False
    name = activity_of(reply).goal.casefold()
    if execution.begun and name != execution.dock_name:
        return True
    execution.dock_name = name
    return False
