"""The commands of one connection in order: what waits, what was sent, what has ended."""
from __future__ import annotations

from typing import Callable, List, Optional

from omron_arcl.errors import Busy
from omron_arcl.execution import Execution, Outcome

MOST_WAITING = 200

# How a stop ends of which the robot took no notice.
_UNHEEDED = (Outcome.TIMED_OUT, Outcome.REJECTED, Outcome.UNKNOWN_COMMAND)


class CommandQueue:
    """Executions in order. `add`, `next_to_send` and `end` keep the rules; all else only looks.

    What is to be told to those who wait gathers in `take_news`, for it is told outside of locks.
    """

    def __init__(self) -> None:
        self.waiting: List[Execution] = []
        self.sent: List[Execution] = []
        self.drivers: List[Execution] = []  # of `sent`: what drives, or is about to, oldest first
        self._news: List[Callable[[], None]] = []
        self._count = 0  # of commands sent

    @property
    def movers(self) -> List[Execution]:
        """Drivers and stops."""
        return [execution for execution in self.sent
                if execution.command.spec.drives or execution.command.name == 'stop']

    def add(self, execution: Execution) -> None:
        """Takes a command; raises Busy. A stop overtakes all that waits, and drops its drives."""
        if execution.command.name == 'stop':
            for other in [e for e in self.waiting if e.command.spec.drives]:
                self.end(other, Outcome.CANCELLED, 'never sent: a stop overtook it')
            self.waiting.insert(0, execution)
        elif len(self.waiting) >= MOST_WAITING:
            raise Busy(f'Not sent, {MOST_WAITING} commands are waiting already.')
        else:
            self.waiting.append(execution)

    def next_to_send(self, now: float) -> Optional[Execution]:
        """The next command to send, if one may go now; it counts as sent."""
        for execution in self.waiting:
            if not self._must_wait(execution):
                self.waiting.remove(execution)
                self.sent.append(execution)
                if execution.command.spec.drives:
                    self.drivers.append(execution)
                execution.heard = now
                self._count += 1
                execution.order = self._count
                return execution
        return None

    def _must_wait(self, execution: Execution) -> bool:
        """Queries of one name wait for each other, and so do answers whose end is not known."""
        spec = execution.command.spec
        if spec.drives or spec.name == 'stop':
            return False
        return any(other.command.name == execution.command.name
                   or (spec.ends is None and other.command.spec.ends is None)
                   for other in self.sent)

    def add_line(self, execution: Execution, text: str, now: float) -> None:
        """A line that belongs to the command."""
        execution.heard = now
        if execution.result is None:
            execution.add_line(text)
            if execution.on_line:
                self._news.append(lambda: execution.on_line(text))

    def end(self, execution: Execution, outcome: Outcome, words: str, keep: bool = False) -> None:
        """Ends it for the asker; `keep` it where its lines are still to come, to nobody."""
        if execution.cancel_requested and outcome is Outcome.INTERRUPTED:
            outcome = Outcome.CANCELLED
        if execution.end(outcome, words):
            self._news.append(execution.announce)
        if not keep:
            for executions in (self.waiting, self.sent, self.drivers):
                if execution in executions:
                    executions.remove(execution)
        if execution.command.name == 'stop' and outcome in _UNHEEDED:
            self._give_up_cancelled(execution, outcome, words)

    def end_before(self, execution: Execution, words: str) -> None:
        """Its effect on the wheels has begun, so that of older commands is over."""
        for other in self.movers:
            if other.order < execution.order:
                self.end(other, Outcome.INTERRUPTED, words)

    def _give_up_cancelled(self, stop: Execution, outcome: Outcome, words: str) -> None:
        """The stop came to nothing: whoever waits for its effect must not for ever."""
        for driver in list(self.drivers):
            if driver.cancel_requested and driver.order < stop.order:
                self.end(driver, outcome, f'stop: {words}')

    def take_news(self) -> List[Callable[[], None]]:
        """What is to be told, in order."""
        news, self._news = self._news, []
        return news
