"""The commands of one connection: commands, lines and time go in, lines to send and results out.

The module has no I/O and no clock. `drives` keeps the records of drives and stops, `command_queue`
keeps the order of the commands, and `attribution` decides on the meaning of lines. The rules:
- Queries with the same name wait for each other, so that each answer belongs to one query.
- A line that names the goal of a driving command acknowledges this command. The command then
  replaces all motions before it, including a stop that is under way.
- `stop` overtakes all unsent commands, and drops the unsent driving commands.
- A `Stopped` ends every stop that was sent before the first driving command about which the robot
  has said nothing. If another client's drive begins while the robot brakes for a stop, the stop
  ends as INTERRUPTED, because the robot does not stand.
- Nothing is ever sent twice. When the link breaks, each command under way ends as LOST.
- A command ends within its time limit, regardless of the robot's answers.
"""
from __future__ import annotations

import math
from typing import Callable, List, Optional

from omron_arcl.attribution import Attribution
from omron_arcl.command_line import parse_command
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import Command, DriveCourse
from omron_arcl.drives import Drives, Overruled
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome, Result
from omron_arcl.replies import Reply

_QUIET = 1.0  # s; without a line for so long, an answer of unknown length is over
_DESCRIPTION_TIMEOUT = 1.0  # s after a CommandError in which its description may come
_LONGEST_ANSWER = 60.0  # s from sending a query or stop to its end, regardless of its lines
_LONGEST_START = 300.0  # s from sending a drive until it is acknowledged
_LONGEST_REPLACEMENT = 5.0  # s; if no newer drive replaces a cancelled one by then, a stop is sent


class Dispatcher:
    """The commands of one connection. The user provides the clock (s, monotonic) and the lock.

    `pop_callbacks` returns the callbacks of the givers of commands. The user runs them without the
    lock, so that a callback may give the next command.
    """

    def __init__(self, records: Optional[Drives] = None) -> None:
        self.records = records or Drives()
        self._commands = CommandQueue(self.records)
        self._attribution = Attribution(self._commands)

    def start(self, command: Command, timeout: Optional[float] = None,
              on_line: Optional[Callable[[str], None]] = None,
              on_end: Optional[Callable[[Result], None]] = None,
              stop_on_timeout: bool = False, giver: Giver = NO_GIVER,
              known_epoch: int = 0, number: int = 0) -> Execution:
        """Takes a command of `giver`, which knows `known_epoch`.

        Raises Busy, Overruled or Unclear. timeout: the command times out after so many s without
        a line about it; None: the timeout of the kind of command. stop_on_timeout: stops a drive
        that has timed out, unless a newer drive is under way. number: the number that the giver
        gives the command (ascending).
        """
        self._check(command, giver, known_epoch, number)
        execution = Execution(command, timeout, on_line, on_end, stop_on_timeout, giver,
                              known_epoch, number)
        self._commands.add(execution)
        self.records.given(execution)
        return execution

    def start_without_link(self, command: Command, giver: Giver, known_epoch: int,
                           number: int = 0) -> None:
        """Takes a stop while there is no link; the stop is sent as soon as there is a link.

        Does nothing for other commands. Raises Overruled.
        """
        if command.spec.stops:
            self._check(command, giver, known_epoch, number)
            self.records.stopped_without_link(giver, number)

    def _check(self, command: Command, giver: Giver, known_epoch: int, number: int) -> None:
        try:
            self.records.check(giver, command, known_epoch, number)
        except Overruled:
            self.records.overruled(giver, number)
            raise

    def on_connected(self, now: float) -> None:
        """Notes that the link is up: commands can be sent from now on."""
        self.records.linked(True, now)

    def cancel(self, execution: Execution, now: float, canceller: Giver = NO_GIVER) -> None:
        """Cancels a command: drops an unsent command, stops a drive, awaits no answer to a query.

        A drive that a newer drive replaces is not stopped: the newer drive ends it. A cancelled
        stop is still sent to the robot.
        """
        if execution.result is not None:
            return
        self._commands.now = now
        self.records.cancelled(execution, canceller)
        if execution.sent and execution.command.spec.drives:
            if execution.progress.cancel_requested is None:
                execution.progress.cancel_requested = now
        else:
            self._commands.end(execution, Outcome.CANCELLED, 'cancelled',
                               keep=execution.sent or execution.command.spec.stops)
        self._stop_if_cancelled(now)

    def next_to_send(self, now: float) -> Optional[bytes]:
        """Returns the next line that may be sent now, or None; its command counts as sent."""
        self._commands.now = now
        execution = self._commands.next_to_send(now)
        return execution.command.line if execution else None

    @property
    def in_doubt(self) -> bool:
        """Whether the next status may decide a doubt, or explain an interruption."""
        return self.records.in_doubt

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """Processes a line of the robot."""
        self._commands.now = now
        self._attribution.on_reply(reply, text, now)
        self._end_doubted(-math.inf)  # only certain doubts: the next lines may remove the others
        self._stop_if_cancelled(now)
        self._stop_if_owed(now)

    def on_time(self, now: float) -> None:
        """Processes the passage of time: timeouts, doubts and due stops."""
        self._commands.now = now
        self._end_doubted(now)
        for execution in list(self._commands.sent):
            if execution in self._commands.sent:  # it may have ended with another command
                self._check_time(execution, now)
        self._stop_if_cancelled(now)
        self._stop_if_owed(now)

    def _end_doubted(self, now: float) -> None:
        """Ends the commands that the robot has contradicted for long enough, or with certainty."""
        for execution, doubt in self.records.settled(now):
            if execution in self._commands.sent:  # it may have ended with another command
                self._commands.end(execution, doubt.outcome, doubt.why)

    def _check_time(self, execution: Execution, now: float) -> None:
        spec, progress = execution.command.spec, execution.progress
        unheard, begun = now - progress.heard, self.records.has_begun(execution)
        # no total limit for a drive that has begun, or for a drive to the dock
        may_take_longer = spec.drives and (begun or spec.course is DriveCourse.INTO_THE_DOCK)
        if progress.rejected_at is not None:
            if now - progress.rejected_at > _DESCRIPTION_TIMEOUT:
                self._commands.end(execution, Outcome.REJECTED, 'the robot gave no reason')
        elif spec.completed_by is None and begun and unheard > _QUIET:
            self._commands.end(execution, Outcome.SUCCEEDED, '')
        else:
            limit = execution.timeout if begun else execution.acknowledge_timeout
            longest = _LONGEST_START if spec.drives else _LONGEST_ANSWER
            if unheard > limit:
                self._commands.end(execution, Outcome.TIMED_OUT,
                                   f'the robot said nothing about it for {limit:.0f} s')
            elif now - progress.sent_at > max(longest, limit) and not may_take_longer:
                self._commands.end(execution, Outcome.TIMED_OUT,
                                   f'it was not done within {max(longest, limit):.0f} s')

    def on_lost(self, reason: str) -> None:
        """Notes that the link broke. Every command ends; only an owed stop is sent again."""
        self.records.linked(False, self._commands.now)
        for execution in self._commands.sent + self._commands.waiting:
            self._commands.end(execution, Outcome.LOST if execution.sent else Outcome.NEVER_SENT,
                               reason)

    def pop_callbacks(self) -> List[Callable[[], None]]:
        """Returns the collected callbacks in order, and clears them."""
        return self._commands.pop_callbacks()

    def _stop_if_cancelled(self, now: float) -> None:
        """Stops the robot if its present or next drive was cancelled.

        If a newer driving command of the same giver replaces the cancelled one, no stop is sent: it
        would also end the newer command. If the replacement takes too long, the stop is sent
        anyway, because the robot may have missed the newer command.
        """
        waiting = any(e.command.spec.drives for e in self._commands.waiting)
        for drive in reversed(self._commands.drives):
            if drive.progress.stopping:
                return  # that stop also ends the older drives
            if drive.progress.cancel_requested is None:
                continue
            newest = drive is self._commands.drives[-1] and not waiting
            theirs = self._commands.drives[-1].giver
            if newest or (drive.giver == theirs
                          and now - drive.progress.cancel_requested > _LONGEST_REPLACEMENT):
                drive.progress.stopping = True
                self._stop()
                return

    def _stop_if_owed(self, now: float) -> None:
        if self.records.stop_due(now):
            self._stop()

    def _stop(self) -> None:
        stop = Execution(parse_command('stop'), giver=self.records.motion.memory.giver)
        self._commands.add(stop)
        self.records.own_stop_given(stop)
