"""Commands in, lines to send out; replies and time in, results out. No I/O, and no clock.

The rules, of which `command_queue` keeps the order and `attribution` the meaning of lines:
- queries of one name wait for each other, so an answer has one asker;
- a driving command is acknowledged by a line that names its goal, and replaces what came before it,
  a stop that is still under way included;
- `stop` overtakes all that is unsent, and unsent driving commands are dropped for it;
- a `Stopped` ends every stop that was sent before the next driving command; a stop that another
  client's drive overtook while the robot braked was interrupted, for the robot does not stand;
- nothing is ever sent twice, and whatever is under way ends as LOST with the link.
"""
from __future__ import annotations

from typing import Callable, List, Optional

from omron_arcl.attribution import Attribution
from omron_arcl.command_line import parse_command
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import PATIENCE, Command
from omron_arcl.execution import Execution, Outcome, Result
from omron_arcl.replies.reply import Reply

_QUIET = 1.0  # s without a line after which an answer of unknown length is over
_DESCRIPTION_DELAY = 1.0  # s that the description may come after its CommandError


class Dispatcher:
    """The commands of one connection. The caller brings the clock (s, monotonic) and the lock.

    `take_news` gives what is to be told to those who wait; it is told outside the lock, so that a
    callback may give the next command.
    """

    def __init__(self) -> None:
        self._commands = CommandQueue()
        self._attribution = Attribution(self._commands)

    def start(self, command: Command, timeout: Optional[float] = None,
              on_line: Optional[Callable[[str], None]] = None,
              on_end: Optional[Callable[[Result], None]] = None) -> Execution:
        """Takes a command; raises Busy. `timeout`: seconds of silence, else the command's own."""
        execution = Execution(command, timeout or command.spec.silence, on_line, on_end)
        self._commands.add(execution)
        return execution

    def cancel(self, execution: Execution) -> None:
        """Ends a command: the unsent is dropped, the driving stopped, a query no longer awaited.

        A driving command that has been replaced is left to the one that replaced it.
        """
        if execution.result is not None:
            return
        if execution.sent and execution.command.spec.drives:
            execution.cancel_requested = True
        else:
            self._commands.end(execution, Outcome.CANCELLED, 'cancelled', keep=execution.sent)
        self._stop_if_cancelled()

    def next_to_send(self, now: float) -> Optional[str]:
        """The next line to send, if one may go now; it counts as sent."""
        execution = self._commands.next_to_send(now)
        return execution.command.text if execution else None

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """A line came."""
        self._attribution.on_reply(reply, text, now)
        self._stop_if_cancelled()

    def on_time(self, now: float) -> None:
        """Time has passed."""
        for execution in list(self._commands.sent):
            silence = now - execution.heard
            if execution.rejected:
                if silence > _DESCRIPTION_DELAY:
                    self._commands.end(execution, Outcome.REJECTED, 'the robot gave no reason')
            elif execution.command.spec.ends is None and execution.begun:
                if silence > _QUIET:
                    self._commands.end(execution, Outcome.SUCCEEDED, '')
            else:
                limit = execution.silence
                if limit is None and not execution.begun:
                    limit = PATIENCE
                if limit is not None and silence > limit:
                    self._commands.end(execution, Outcome.TIMED_OUT,
                                       f'the robot said nothing about it for {limit:.0f} s')
        self._stop_if_cancelled()

    def on_lost(self, reason: str) -> None:
        """The link broke: nothing is sent again, everything ends."""
        for execution in self._commands.sent + self._commands.waiting:
            never = '' if execution.sent else 'never sent: '
            self._commands.end(execution, Outcome.LOST, never + reason)

    def take_news(self) -> List[Callable[[], None]]:
        """What is to be told, in order."""
        return self._commands.take_news()

    def _stop_if_cancelled(self) -> None:
        """Stops the robot when what it does, or is about to do, is no longer wanted.

        A driving command that waits goes out next and replaces it; a stop would drop that one.
        """
        drivers = self._commands.drivers
        if (drivers and drivers[-1].cancel_requested and not drivers[-1].stopping
                and not any(e.command.spec.drives for e in self._commands.waiting)):
            drivers[-1].stopping = True
            self.start(parse_command('stop'))
