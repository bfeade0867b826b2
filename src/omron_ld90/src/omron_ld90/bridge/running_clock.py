"""A clock that stops while this process is suspended.

While a process is suspended, or gets no processor time for seconds, it cannot read the messages
that arrive. So no timeout may count this time.
"""
from __future__ import annotations

import time
from typing import Callable

LONGEST_STEP = 0.5  # s, maximum time that counts between two readings


class RunningClock:
    """A clock in seconds that advances by at most `LONGEST_STEP` from one reading to the next."""

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._monotonic = monotonic
        self._last = monotonic()
        self._now = 0.0

    def read(self) -> float:
        """Returns the time in s; must be read several times a second."""
        now = self._monotonic()
        self._now += min(now - self._last, LONGEST_STEP)
        self._last = now
        return self._now
