"""When the fleet manager is told how things are, although nothing has changed."""
from __future__ import annotations

import math

TICK = 0.1         # s between two looks at the clock
IDLE_PERIOD = 1.0  # s between two reports without a route


class ReportSchedule:
    """At every tick (10 Hz) while a route runs, at 1 Hz otherwise."""

    def __init__(self) -> None:
        self._last = -math.inf

    def is_due(self, running: bool, now: float) -> bool:
        """Is a report to be sent now? A tick may come up to half a tick too soon."""
        period = TICK if running else IDLE_PERIOD
        if now - self._last < period - TICK / 2.0:
            return False
        self._last = now
        return True
