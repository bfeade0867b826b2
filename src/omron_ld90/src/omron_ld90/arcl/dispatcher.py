"""Which line of the robot belongs to which command: attribution without I/O and without a clock.

The robot answers in the order of sending, with lines that carry no id. The rules:
- queries of one name wait for each other, so an answer has one asker;
- a driving command is acknowledged by a line that names its goal, and replaces what came before it,
  a stop that is still under way included;
- `stop` overtakes all that is unsent, and unsent driving commands are dropped for it;
- a `Stopped` ends every stop that was sent before the next driving command;
- nothing is ever sent twice, and whatever is under way ends as LOST with the link.
"""
from __future__ import annotations

from typing import Callable, Dict, List, Optional, Type

from omron_ld90.arcl import replies as r
from omron_ld90.arcl.command_table import PATIENCE
from omron_ld90.arcl.commands import Command
from omron_ld90.arcl.errors import Busy
from omron_ld90.arcl.execution import Execution, Outcome, Result
from omron_ld90.arcl.parser import parse_line
from omron_ld90.arcl.replies import Reply

MOST_WAITING = 200
_QUIET = 1.0  # s without a line after which an answer of unknown length is over
_DESCRIPTION_DELAY = 1.0  # s that the description may come after its CommandError
_CUT_NAME = 16  # characters to which the robot cuts an unknown command's name


class Dispatcher:
    """The commands of one connection. The caller brings the clock (s, monotonic) and the lock.

    `take_news` gives what is to be told to those who wait; it is told outside the lock, so that a
    callback may give the next command.
    """

    def __init__(self) -> None:
        self._waiting: List[Execution] = []
        self._sent: List[Execution] = []
        self._news: List[Callable[[], None]] = []
        self._count = 0  # of commands sent

    # --- commands in --------------------------------------------------------------------------

    def start(self, command: Command, timeout: Optional[float] = None,
              on_line: Optional[Callable[[str], None]] = None,
              on_end: Optional[Callable[[Result], None]] = None) -> Execution:
        """Takes a command; raises Busy. `timeout`: seconds of silence, else the command's own."""
        stop = command.name == 'stop'
        if len(self._waiting) >= MOST_WAITING and not stop:
            raise Busy(f'Not sent, {MOST_WAITING} commands are waiting already.')
        execution = Execution(command, timeout or command.spec.silence, on_line, on_end)
        if stop:
            for other in [e for e in self._waiting if e.command.spec.drives]:
                self._end(other, Outcome.CANCELLED, 'never sent: a stop overtook it')
            self._waiting.insert(0, execution)
        else:
            self._waiting.append(execution)
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
            self._end(execution, Outcome.CANCELLED, 'cancelled', keep=execution.sent)
        self._stop_if_cancelled()

    def next_to_send(self, now: float) -> Optional[str]:
        """The next line to send, if one may go now; it counts as sent."""
        for execution in self._waiting:
            if not self._must_wait(execution):
                self._waiting.remove(execution)
                self._sent.append(execution)
                execution.heard = now
                self._count += 1
                execution.order = self._count
                return execution.command.text
        return None

    def _must_wait(self, execution: Execution) -> bool:
        spec = execution.command.spec
        if spec.drives or spec.name == 'stop':
            return False
        return any(other.command.name == execution.command.name
                   or (spec.ends is None and other.command.spec.ends is None)
                   for other in self._sent)

    # --- what happens ----------------------------------------------------------------------------

    def on_reply(self, reply: Reply, text: str, now: float) -> None:
        """A line came."""
        if not self._sent:
            return
        handle = _SPECIAL.get(type(reply))
        if handle:
            handle(self, reply, text, now)
        self._offer(reply, text, now)
        self._stop_if_cancelled()

    def on_time(self, now: float) -> None:
        """Time has passed."""
        for execution in list(self._sent):
            silence = now - execution.heard
            if execution.rejected:
                if silence > _DESCRIPTION_DELAY:
                    self._end(execution, Outcome.REJECTED, 'the robot gave no reason')
            elif execution.command.spec.ends is None and execution.begun:
                if silence > _QUIET:
                    self._end(execution, Outcome.SUCCEEDED, '')
            else:
                limit = execution.silence
                if limit is None and not execution.begun:
                    limit = PATIENCE
                if limit is not None and silence > limit:
                    words = f'the robot said nothing about it for {limit:.0f} s'
                    self._end(execution, Outcome.TIMED_OUT, words)
        self._stop_if_cancelled()

    def on_lost(self, reason: str) -> None:
        """The link broke: nothing is sent again, everything ends."""
        for execution in self._sent + self._waiting:
            never = '' if execution.sent else 'never sent: '
            self._end(execution, Outcome.LOST, never + reason)

    def take_news(self) -> List[Callable[[], None]]:
        """What is to be told, in order."""
        news, self._news = self._news, []
        return news

    # --- attribution -----------------------------------------------------------------------------

    def _offer(self, reply: Reply, text: str, now: float) -> None:
        claimed = self._offer_to_drivers(reply, text, now)
        stopped = False
        for execution in list(self._sent):
            spec, command = execution.command.spec, execution.command
            if spec.drives:
                if stopped:
                    return  # the stops behind it are still to come
                continue
            if spec.ends is None:
                if claimed or isinstance(reply, _BROADCAST):
                    continue
                execution.begun = True
                self._line(execution, text, now)
            elif spec.ends(command, reply):
                self._line(execution, text, now)
                self._end(execution, Outcome.SUCCEEDED, text)
                if spec.name == 'stop':
                    stopped = True
                    self._end_before(execution, text)
                    continue
            elif spec.belongs and spec.belongs(command, reply):
                self._line(execution, text, now)
            else:
                continue
            return

    def _offer_to_drivers(self, reply: Reply, text: str, now: float) -> bool:
        drivers = self._drivers()
        begun = [e for e in reversed(drivers) if e.begun]
        fresh = [e for e in drivers if not e.begun]
        for execution in begun + fresh:
            spec, command = execution.command.spec, execution.command
            if spec.ends(command, reply):
                self._line(execution, text, now)
                self._end(execution, Outcome.SUCCEEDED, text)
                return True
        for execution in fresh + begun:
            spec, command = execution.command.spec, execution.command
            if spec.begins(command, reply):
                self._line(execution, text, now)
                if not execution.begun:
                    execution.begun = True
                    self._end_before(execution, f'replaced by "{command.text}"')
                return True
        for execution in begun + fresh:
            spec, command = execution.command.spec, execution.command
            if execution.begun and spec.undone and spec.undone(command, reply):
                self._line(execution, text, now)
                self._end(execution, Outcome.INTERRUPTED, text)
                return True
            if spec.belongs(command, reply):
                self._line(execution, text, now)
                return True
        if isinstance(reply, _SETTING_OUT):
            for execution in begun:
                self._end(execution, Outcome.INTERRUPTED, f'taken over: {text}')
        return False

    def _drivers(self) -> List[Execution]:
        return [e for e in self._sent if e.command.spec.drives]

    def _end_before(self, execution: Execution, words: str) -> None:
        """Its effect on the wheels has begun, so that of older commands is over."""
        for other in list(self._sent):
            moves = other.command.spec.drives or other.command.name == 'stop'
            if moves and other.order < execution.order:
                self._end(other, Outcome.INTERRUPTED, words)

    def _give_up_cancelled(self, stop: Execution, outcome: Outcome, words: str) -> None:
        """The stop came to nothing: whoever waits for its effect must not for ever."""
        for driver in self._drivers():
            if driver.cancel_requested and driver.order < stop.order:
                self._end(driver, outcome, f'stop: {words}')

    def _line(self, execution: Execution, text: str, now: float) -> None:
        execution.heard = now
        if execution.result is None:
            execution.add_line(text)
            if execution.on_line:
                self._news.append(lambda: execution.on_line(text))

    def _end(self, execution: Execution, outcome: Outcome, words: str, keep: bool = False) -> None:
        """Ends it for the asker; `keep` it where its lines are still to come, to nobody."""
        if execution.cancel_requested and outcome is Outcome.INTERRUPTED:
            outcome = Outcome.CANCELLED
        if execution.end(outcome, words):
            self._news.append(execution.announce)
        if not keep:
            for executions in (self._waiting, self._sent):
                if execution in executions:
                    executions.remove(execution)
        if execution.command.name == 'stop' and outcome in _UNHEEDED:
            self._give_up_cancelled(execution, outcome, words)

    def _stop_if_cancelled(self) -> None:
        """Stops the robot when what it does, or is about to do, is no longer wanted.

        A driving command that waits goes out next and replaces it; a stop would drop that one.
        """
        drivers = self._drivers()
        if (drivers and drivers[-1].cancel_requested and not drivers[-1].stopping
                and not any(e.command.spec.drives for e in self._waiting)):
            drivers[-1].stopping = True
            self.start(Command.parse('stop'))

    # --- what ends commands badly ----------------------------------------------------------------

    def _on_command_error(self, reply: r.CommandError, text: str, now: float) -> None:
        """The robot repeats the line; the description follows, perhaps after other lines."""
        refused = ' '.join(reply.command.split()).casefold()
        for execution in self._sent:
            given = ' '.join(execution.command.text.split()).casefold()
            if given == refused and not execution.rejected and not execution.begun:
                execution.rejected = True
                self._line(execution, text, now)
                return

    def _on_description(self, reply: r.CommandErrorDescription, text: str, now: float) -> None:
        for execution in self._sent:
            if execution.rejected:
                no_goal = reply.text.lower().startswith('no goal')
                self._line(execution, text, now)
                self._end(execution, Outcome.NO_GOAL if no_goal else Outcome.REJECTED, reply.text)
                return

    def _on_unknown_command(self, reply: r.UnknownCommand, text: str, now: float) -> None:
        said = reply.name.strip().lower()
        for execution in self._sent:
            given = execution.command.text.split(' ', 1)[0].lower()
            if given == said or (len(said) >= _CUT_NAME and given.startswith(said)) or not said:
                self._line(execution, text, now)
                self._end(execution, Outcome.UNKNOWN_COMMAND, text)
                return

    def _on_setup_error(self, reply: r.SetUpError, text: str, now: float) -> None:
        """It names no command: the oldest that can still be refused is meant."""
        for execution in self._sent:
            if not execution.begun:
                self._line(execution, text, now)
                self._end(execution, Outcome.REJECTED, reply.text)
                return

    def _on_interrupted(self, reply: r.Interrupted, text: str, now: float) -> None:
        ran = parse_line(reply.text)
        begun = [e for e in self._drivers() if e.begun]
        for execution in begun:
            spec, command = execution.command.spec, execution.command
            if spec.begins(command, ran) or spec.belongs(command, ran):
                break
        else:
            if not begun or not isinstance(ran, r.UnknownLine):
                return
            execution = begun[-1]
        self._line(execution, text, now)
        self._end(execution, Outcome.INTERRUPTED, text)

    def _on_error(self, reply: r.RobotError, text: str, now: float) -> None:
        """It names no command: what drives, or else what was to drive first, has failed."""
        drivers = self._drivers()
        if drivers:
            begun = [e for e in drivers if e.begun]
            execution = begun[-1] if begun else drivers[0]
            self._line(execution, text, now)
            self._end(execution, Outcome.FAILED, reply.text)

    def _on_failed_going(self, reply: r.FailedGoingTo, text: str, now: float) -> None:
        for execution in self._drivers():
            if execution.command.is_for(reply.goal):
                self._line(execution, text, now)
                self._end(execution, Outcome.FAILED, text)
                return

    def _on_estop(self, reply: r.EStop, text: str, now: float) -> None:
        if reply.pressed:
            self._end_powerless(Outcome.EMERGENCY_STOPPED, text, now)

    def _on_motors(self, reply: r.Motors, text: str, now: float) -> None:
        if not reply.enabled:
            self._end_powerless(Outcome.FAILED, text, now)

    def _end_powerless(self, outcome: Outcome, text: str, now: float) -> None:
        """Without motors nothing drives, and the robot takes no goal up again by itself."""
        for execution in list(self._sent):
            if execution.command.spec.drives or execution.command.name == 'enableMotors':
                self._line(execution, text, now)
                self._end(execution, outcome, text)

    def _on_status(self, reply: Reply, text: str, now: float) -> None:
        """A status that tells of the drive is a sign of life from it, though no line of its own."""
        status = reply.status if isinstance(reply, r.OneLineStatus) else reply.text
        doing = parse_line(status)
        for execution in self._drivers():
            if execution.begun and execution.command.spec.begins(execution.command, doing):
                execution.heard = now


_SPECIAL: Dict[Type[Reply], Callable[[Dispatcher, Reply, str, float], None]] = {
    r.CommandError: Dispatcher._on_command_error,
    r.CommandErrorDescription: Dispatcher._on_description,
    r.UnknownCommand: Dispatcher._on_unknown_command,
    r.SetUpError: Dispatcher._on_setup_error,
    r.Interrupted: Dispatcher._on_interrupted,
    r.RobotError: Dispatcher._on_error,
    r.FailedGoingTo: Dispatcher._on_failed_going,
    r.EStop: Dispatcher._on_estop,
    r.Motors: Dispatcher._on_motors,
    r.OneLineStatus: Dispatcher._on_status,
    r.StatusText: Dispatcher._on_status,
}

# How a stop ends of which the robot took no notice.
_UNHEEDED = (Outcome.TIMED_OUT, Outcome.REJECTED, Outcome.UNKNOWN_COMMAND)

# Said to everybody: these never answer a command whose answer is not known.
_BROADCAST = (r.DockingStatus, r.GoingTo, r.GoingToPoint, r.ArrivedAt, r.ArrivedAtPoint, r.Parking,
              r.Stopping, r.Stopped, r.Interrupted, r.RobotError, r.EStop, r.Motors, r.MapChanged,
              r.ConfigurationChanged, r.WaitState, r.Notice, r.OneLineStatus, r.StatusText,
              r.RangeReading, r.CommandError, r.CommandErrorDescription, r.UnknownCommand)

# The robot set out for something that no command of ours asked for.
_SETTING_OUT = (r.GoingTo, r.GoingToPoint, r.Patrolling, r.ExecutingMacro, r.DoingTask)
