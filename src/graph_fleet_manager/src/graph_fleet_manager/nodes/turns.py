"""The turns of events: which kind of event the deciding thread takes next.

| event      | when its turn is                                                                  |
|------------|-----------------------------------------------------------------------------------|
| a stop     | at once                                                                           |
| a command  | before reports                                                                    |
| a tick     | when it is due, and no command waits, and no report that arrived before that time |
|            | waits; at the latest LATEST after that time, even if other events wait            |
| a report   | when no command waits                                                             |
| requests   | when nothing else waits, and once before each tick                                |

So under any load, a tick is late by at most LATEST plus the time of one event and one turn of
requests. LATEST counts from the end of the last tick, so slow ticks do not stop other events.
"""
from __future__ import annotations

from enum import Enum
from typing import NamedTuple, Optional

TICK = 0.05    # s between two ticks
LATEST = 0.2   # s by which commands and reports may delay a tick that is due


class TurnKind(Enum):
    """The kind of an event that has its turn."""

    STOP = 'stop'
    COMMAND = 'command'
    TICK = 'tick'
    REPORT = 'report'
    REQUEST = 'request'


class Waiting(NamedTuple):
    """The events that wait. `report`: the time when the oldest report arrived; None: no report."""

    stop: bool = False
    command: bool = False
    report: Optional[float] = None
    request: bool = False


class Turns:
    """The order of events, and the times of ticks. Times are monotonic, in s.

    now -- the present time; a tick is due at once
    """

    def __init__(self, now: float) -> None:
        self.due = self._free = now
        self.heard = now
        """At the last tick, all reports that had arrived before this time were handled."""
        self._due_since: Optional[float] = None
        """When the next tick became due; reports from before come first. None: it is not due."""
        self._had_turn = False  # whether requests had a turn since the last tick

    def hurry(self, due: Optional[float]) -> None:
        """Makes the next tick due at `due`, unless it is due earlier; None changes nothing."""
        if due is not None:
            self.due = min(self.due, due)

    def put_off(self, due: float) -> None:
        """Puts the next tick off to this time, even if the tick is already due."""
        self.due, self._due_since = due, None
        self._free = max(self._free, due)

    def next(self, waiting: Waiting, now: float) -> Optional[TurnKind]:
        """Returns the kind of event that is next; None: no event is taken before the next tick."""
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
        """Notes that the tick that was taken last has ended."""
        self._free = now
