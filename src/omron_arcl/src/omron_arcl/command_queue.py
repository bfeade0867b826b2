"""The commands of one connection in order: waiting commands, and sent ones until they end.

    event                                     waiting              sent
    a stop is given                           drives: ended        -
    the connection accepts data               sent; if its epoch   -
                                              is old: ended; a
                                              query may wait for
                                              an earlier query
    a newer drive is acknowledged, or         -                    older drives and stops: ended
    completed at once
    a stop has succeeded                      -                    older drives and stops: ended
    the last line of the command, a doubt,    -                    ended
    or its time limit
    it is cancelled; the link breaks          ended                ended

Invariants: nothing is sent twice. A command ends once. Drives and stops are sent in the order of
their records (`drives`).
"""
from __future__ import annotations

from typing import Callable, List, Optional

from omron_arcl.drives import UNHEEDED, Drives
from omron_arcl.errors import Busy
from omron_arcl.execution import Execution, Outcome

MAXIMUM_WAITING = 200


class CommandQueue:
    """The commands in order. Only `add`, `next_to_send` and `end` change the order.

    The queue collects the callbacks to callers for `pop_callbacks`, so that they run without locks.
    """

    def __init__(self, records: Drives) -> None:
        self.records = records
        self.now = 0.0
        self.waiting: List[Execution] = []
        self.sent: List[Execution] = []
        self._callbacks: List[Callable[[], None]] = []
        self._count = 0  # number of commands sent

    @property
    def drives(self) -> List[Execution]:
        """The drives in `sent`, the oldest first."""
        return [execution for execution in self.sent if execution.command.spec.drives]

    @property
    def motion_executions(self) -> List[Execution]:
        """The drives and stops in `sent`."""
        return [execution for execution in self.sent
                if execution.command.spec.drives or execution.command.spec.stops]

    @property
    def begun_drives(self) -> List[Execution]:
        """The drives in `sent` that the robot has acknowledged."""
        return [execution for execution in self.drives if self.records.has_begun(execution)]

    def add(self, execution: Execution) -> None:
        """Adds a command; raises Busy. A stop overtakes all waiting commands, and ends the waiting
        drives.
        """
        if execution.command.spec.stops:
            for other in [e for e in self.waiting if e.command.spec.drives]:
                outcome = (Outcome.CANCELLED if other.giver == execution.giver
                           else Outcome.OVERRULED)
                self.end(other, outcome, 'never sent: a stop overtook it')
            stops = sum(other.command.spec.stops for other in self.waiting)
            self.waiting.insert(stops, execution)
        elif len(self.waiting) >= MAXIMUM_WAITING:
            raise Busy(MAXIMUM_WAITING, 'commands')
        else:
            self.waiting.append(execution)

    def next_to_send(self, now: float) -> Optional[Execution]:
        """Returns the next command that may be sent now, or None; it counts as sent."""
        for execution in list(self.waiting):
            if not self.records.may_send(execution):
                self.end(execution, Outcome.OVERRULED, 'another command came first')
            elif not self._must_wait(execution):
                self.waiting.remove(execution)
                self.sent.append(execution)
                self._count += 1
                execution.order = self._count
                execution.progress.begin(now, self.records.heard.shown)
                self.records.sent(execution)
                return execution
        return None

    def _must_wait(self, execution: Execution) -> bool:
        """Returns whether a query must wait for an earlier query: both have the same name, or both
        have undocumented answers.
        """
        spec = execution.command.spec
        if spec.drives or spec.stops:
            return False
        return any(other.command.name == execution.command.name
                   or (spec.completed_by is None and other.command.spec.completed_by is None)
                   for other in self.sent)

    def add_line(self, execution: Execution, text: str, now: float,
                 sign_of_life: bool = True) -> None:
        """Adds a line of the command; `sign_of_life`: the line shows that the command goes on."""
        if sign_of_life:
            execution.progress.heard = now
        if execution.result is None:
            execution.add_line(text)
            if execution.on_line:
                on_line = execution.on_line
                self._callbacks.append(lambda: on_line(text))

    def begin(self, execution: Execution, line: str) -> None:
        """Notes that the robot obeys a drive, and ends the motions before this drive.

        line -- the line or status that shows that the robot obeys it
        """
        if not self.records.has_begun(execution):
            self.records.acknowledged(execution, line)
            self.end_before(execution, f'replaced by "{execution.command.text}"')

    def end(self, execution: Execution, outcome: Outcome, words: str, keep: bool = False) -> None:
        """Ends a command for its caller.

        keep -- the command stays in the queue, because its lines may still come; they are ignored
        """
        if execution.progress.cancel_requested is not None and outcome is Outcome.INTERRUPTED:
            outcome = Outcome.CANCELLED
        if execution.command.spec.drives and outcome is Outcome.SUCCEEDED:
            self.begin(execution, words)  # the robot may complete a drive at once
        if execution.end(outcome, words):
            self._callbacks.append(execution.announce)
        if not keep:
            for executions in (self.waiting, self.sent):
                if execution in executions:
                    executions.remove(execution)
            self.records.ended(execution, outcome, words, self.now)
        if execution.command.spec.stops and outcome is Outcome.SUCCEEDED:
            self.end_before(execution, words)
        elif execution.command.spec.stops and outcome in UNHEEDED:
            self._give_up_cancelled(execution, outcome, words)

    def end_before(self, execution: Execution, words: str) -> None:
        """Ends older motions, because the motion of `execution` has begun."""
        for other in self.motion_executions:
            if other.order < execution.order:
                self.end(other, Outcome.INTERRUPTED, words)

    def _give_up_cancelled(self, stop: Execution, outcome: Outcome, words: str) -> None:
        """Ends the cancelled drives that waited for a stop; the stop has failed."""
        for drive in self.drives:
            if drive.progress.cancel_requested is not None and drive.order < stop.order:
                self.end(drive, outcome, f'stop: {words}')

    def pop_callbacks(self) -> List[Callable[[], None]]:
        """Returns and clears the collected callbacks, in order."""
        callbacks, self._callbacks = self._callbacks, []
        return callbacks
