"""Whose turn it is: which kind of event the thread that decides takes next.

| what waits | when it has its turn                                                              |
|------------|-----------------------------------------------------------------------------------|
| a stop     | at once                                                                           |
| a command  | before reports                                                                    |
| a tick     | when it is due, no command waits, and no report that arrived before it was due;   |
|            | LATEST after it was due, with all that waits                                      |
| a report   | when no command waits                                                             |
| requests   | when nothing else waits, and once before each tick                                |

So no load keeps a tick away for longer than LATEST, one event and one turn of requests. Ticks that
take long do not keep the others away: LATEST counts from the end of the last tick.
"""
from __future__ import annotations

from enum import Enum
from typing import NamedTuple, Optional

TICK = 0.05    # s between two ticks
LATEST = 0.2   # s for which commands and reports may keep away a tick that is due


class TurnKind(Enum):
    """What has its turn."""

    STOP = 'stop'
    COMMAND = 'command'
    TICK = 'tick'
    REPORT = 'report'
    REQUEST = 'request'


class Waiting(NamedTuple):
    """What waits. `report` is the time at which the oldest report arrived; None: no report."""

    stop: bool = False
    command: bool = False
    report: Optional[float] = None
    request: bool = False


class Turns:
    """The order of events, and the clock of the ticks. Times are monotonic, in s.

    now -- a tick is due at once
    """

    def __init__(self, now: float) -> None:
        self.due = self._free = now
        self.heard = now
        """At the last tick, the time until which all reports were handled."""
        self._due_since: Optional[float] = None
        """When the next tick became due: it comes after the reports until then. None: not due."""
        self._had_turn = False  # whether requests had a turn since the last tick

    def hurry(self, due: Optional[float]) -> None:
        """Moves the next tick forward to `due` if it is earlier; None changes nothing."""
        if due is not None:
            self.due = min(self.due, due)

    def put_off(self, due: float) -> None:
        """Puts the next tick off to this time, however long it has been due already."""
        self.due, self._due_since = due, None
        self._free = max(self._free, due)

    def next(self, waiting: Waiting, now: float) -> Optional[TurnKind]:
        """Returns what has its turn; None: nothing before the next tick is due."""
        if self._due_since is None and now >= self.due:
            self._due_since = now
        since = self._due_since
        if waiting.stop:
            return TurnKind.STOP
        is_late = since is not None and now >= max(self.due, self._free) + LATEST
        if waiting.command and not is_late:
            return TurnKind.COMMAND
        if waiting.report is not None and not is_late and (
                since is None or waiting.report <= since):
            return TurnKind.REPORT
        if waiting.request and (since is None or not self._had_turn):
            self._had_turn = True
            return TurnKind.REQUEST
        return None if since is None else self._tick(waiting, since, now)

    def _tick(self, waiting: Waiting, since: float, now: float) -> TurnKind:
        heard = since if waiting.report is None else min(since, waiting.report)
        self.heard = max(self.heard, heard)
        self.due, self._due_since, self._had_turn = now + TICK, None, False
        return TurnKind.TICK

    def ended(self, now: float) -> None:
        """Notes that the tick, as the last event, has ended."""
        self._free = now
