"""A clock that does not run while this process stands still.

A process that was stopped, or got no processor for seconds, has not seen that nothing happened: the
messages of that time are still to be read. So no timeout may count it.
"""
from __future__ import annotations

import time
from typing import Callable

LONGEST_STEP = 0.5  # s between two readings that count


class RunningClock:
    """Seconds since some moment, never more than `LONGEST_STEP` at a time."""

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._monotonic = monotonic
        self._last = monotonic()
        self._now = 0.0

    def read(self) -> float:
        """The time; to be read several times a second."""
        now = self._monotonic()
        self._now += min(now - self._last, LONGEST_STEP)
        self._last = now
        return self._now
