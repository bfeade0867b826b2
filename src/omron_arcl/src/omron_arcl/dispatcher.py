"""Commands in, lines to send out; replies and time in, results out. No I/O, and no clock.

The rules, of which `command_queue` keeps the order, `attribution` the meaning of lines, and
`drive_watch` what the robot's status says of a drive:
- queries of one name wait for each other, so an answer has one asker;
- a driving command is acknowledged by a line that names its goal, and replaces what came before it,
  a stop that is still under way included;
- `stop` overtakes all that is unsent, and unsent driving commands are dropped for it;
- a `Stopped` ends every stop that was sent before the next driving command; a stop that another
  client's drive overtook while the robot braked was interrupted, for the robot does not stand;
- nothing is ever sent twice, and each command under way ends as LOST with the link;
- a command ends within its bound, regardless of the robot's answers.
"""
from __future__ import annotations

from typing import Callable, List, Optional

from omron_arcl.attribution import Attribution
from omron_arcl.command_line import parse_command
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import Command, Course
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome, Result
from omron_arcl.motion_authority import MotionAuthority
from omron_arcl.replies.reply import Reply

_QUIET = 1.0  # s without a line after which an answer of unknown length is over
_DESCRIPTION_TIMEOUT = 1.0  # s that the description may come after its CommandError
_LONGEST_ANSWER = 60.0  # s from sending a query or stop, however much the robot has to say
_LONGEST_START = 300.0  # s from sending a drive until it is acknowledged
_LONGEST_REPLACEMENT = 5.0  # s in which a newer drive must replace a cancelled one, else a stop


def _may_take_longer(execution: Execution) -> bool:
    """A drive under way, and the way to the dock, which comes before the robot says it docks."""
    spec = execution.command.spec
    return spec.drives and (execution.begun or spec.course is Course.INTO_THE_DOCK)


class Dispatcher:
    """The commands of one connection. The caller brings the clock (s, monotonic) and the lock.

    `pop_callbacks` gives what is to be told to the waiting callers; it is told outside the lock, so
    that a callback may give the next command.
    """

    def __init__(self, authority: Optional[MotionAuthority] = None) -> None:
        self.authority = authority or MotionAuthority()
        self._commands = CommandQueue(self.authority)
        self._attribution = Attribution(self._commands)

    def start(self, command: Command, timeout: Optional[float] = None,
              on_line: Optional[Callable[[str], None]] = None,
              on_end: Optional[Callable[[Result], None]] = None,
              stop_on_timeout: bool = False, giver: Giver = NO_GIVER,
              known_epoch: int = 0) -> Execution:
        """Takes a command of `giver`, which knows of the epoch; raises Busy, Overruled or Unclear.

        timeout: seconds without a word about it, else the command's own. stop_on_timeout: a drive
        that has timed out is stopped, unless a newer one is under way.
        """
        self.authority.check(giver, command, known_epoch)
        execution = Execution(command, timeout, on_line, on_end, stop_on_timeout, giver,
                              known_epoch)
        execution.replaces = bool(self._commands.drives)
        self._commands.add(execution)
        self.authority.take(execution)
        return execution

    def start_without_link(self, command: Command, giver: Giver, known_epoch: int) -> None:
        """A command is given while there is no link: a stop is sent as soon as there is one.

        Raises Overruled.
        """
        if command.spec.stops:
            self.authority.check(giver, command, known_epoch)
            self.authority.owe_stop_without_link(giver)

    def on_connected(self, now: float) -> None:
        """Commands can be sent from now on."""
        self.authority.on_link(True, now)

    def cancel(self, execution: Execution, now: float, canceller: Giver = NO_GIVER) -> None:
        """Ends a command: the unsent is dropped, the driving stopped, a query no longer awaited.

        A driving command that has been replaced is left to the one that replaced it. A stop goes
        to the robot anyway.
        """
        if execution.result is not None:
            return
        self._commands.now = now
        self.authority.take_cancellation(execution, canceller)
        if execution.sent and execution.command.spec.drives:
            if execution.cancel_requested is None:
                execution.cancel_requested = now
        else:
            self._commands.end(execution, Outcome.CANCELLED, 'cancelled',
                               keep=execution.sent or execution.command.spec.stops)
        self._stop_if_cancelled(now)

    def next_to_send(self, now: float) -> Optional[bytes]:
        """The next line to send, if one may go now; it counts as sent."""
        self._commands.now = now
        execution = self._commands.next_to_send(now)
        if execution is None:
            return None
        execution.shown_when_sent = self._attribution.watch.shown
        return execution.command.line

    @property
    def in_doubt(self) -> bool:
        """Whether a status of the robot would tell whether a drive or stop is over."""
        return self._attribution.watch.in_doubt

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """A line came."""
        self._commands.now = now
        self._attribution.on_reply(reply, text, now)
        self._stop_if_cancelled(now)
        self._stop_if_owed(now)

    def on_time(self, now: float) -> None:
        """Time has passed."""
        self._commands.now = now
        self._attribution.watch.on_time(now)
        for execution in list(self._commands.sent):
            if execution in self._commands.sent:  # not ended with another
                self._check_time(execution, now)
        self._stop_if_cancelled(now)
        self._stop_if_owed(now)

    def _check_time(self, execution: Execution, now: float) -> None:
        spec = execution.command.spec
        unheard = now - (execution.heard or 0.0)
        if execution.rejected_at is not None:
            if now - execution.rejected_at > _DESCRIPTION_TIMEOUT:
                self._commands.end(execution, Outcome.REJECTED, 'the robot gave no reason')
        elif spec.completed_by is None and execution.begun and unheard > _QUIET:
            self._commands.end(execution, Outcome.SUCCEEDED, '')
        else:
            limit = execution.timeout if execution.begun else execution.acknowledge_timeout
            longest = _LONGEST_START if spec.drives else _LONGEST_ANSWER
            if unheard > limit:
                self._time_out(execution, f'the robot said nothing about it for {limit:.0f} s')
            elif now - execution.sent_at > max(longest, limit) and not _may_take_longer(execution):
                self._time_out(execution, f'it was not done within {max(longest, limit):.0f} s')

    def _time_out(self, execution: Execution, words: str) -> None:
        newest = execution in self._commands.drives[-1:] and not any(
            other.command.spec.drives for other in self._commands.waiting)
        self._commands.end(execution, Outcome.TIMED_OUT, words)
        if execution.stop_on_timeout and newest:
            self._stop()

    def on_lost(self, reason: str) -> None:
        """The link broke: nothing is sent again but a stop that is owed, everything ends."""
        self.authority.on_link(False, self._commands.now)
        for execution in self._commands.sent + self._commands.waiting:
            self._commands.end(execution, Outcome.LOST if execution.sent else Outcome.NEVER_SENT,
                               reason)

    def pop_callbacks(self) -> List[Callable[[], None]]:
        """What is to be told, in order."""
        return self._commands.pop_callbacks()

    def _stop_if_cancelled(self, now: float) -> None:
        """Stops the robot when what it does, or is about to do, is no longer wanted.

        A newer driving command replaces a cancelled one; a stop would end that one, too. But it
        must do so soon: the robot may have missed it.
        """
        waiting = any(e.command.spec.drives for e in self._commands.waiting)
        for drive in reversed(self._commands.drives):
            if drive.stopping:
                return  # that stop is meant for the older ones, too
            if drive.cancel_requested is None:
                continue
            newest = drive is self._commands.drives[-1] and not waiting
            theirs = self._commands.drives[-1].giver
            if newest or (drive.giver == theirs
                          and now - drive.cancel_requested > _LONGEST_REPLACEMENT):
                drive.stopping = True
                self._stop()
                return

    def _stop_if_owed(self, now: float) -> None:
        if self.authority.stop_due(now):
            self._stop()

    def _stop(self) -> None:
        stop = Execution(parse_command('stop'), giver=self.authority.motion.memory.giver)
        self._commands.add(stop)
        self.authority.take_own_stop(stop)
