"""One clock for all events of a model."""
from __future__ import annotations

import heapq
from typing import Callable, List, Tuple

MOST_AT_ONCE = 2000
"""If so many calls follow without a pause, two parts of the model answer each other for ever."""


class Timeline:
    """Calls that are due at a time (s). Calls with the same time keep the order of the requests."""

    def __init__(self, now: float) -> None:
        self.now = now
        self._due: List[Tuple[float, int, Callable[[], None]]] = []
        self._count = 0

    def later(self, seconds: float, call: Callable[[], None]) -> None:
        """Calls a function after some seconds."""
        self._count += 1
        heapq.heappush(self._due, (self.now + seconds, self._count, call))

    def every(self, period: float, call: Callable[[], None]) -> None:
        """Calls a function periodically, the first time at once."""
        def again() -> None:
            self.later(period, again)
            call()
        self.later(0.0, again)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Runs for some time, or until the condition is true. Returns whether it became true."""
        end, at_once = self.now + seconds, 0
        while not until():
            if not self._due or self._due[0][0] > end:
                self.now = end
                return False
            before = self.now
            self.now, _, call = heapq.heappop(self._due)
            at_once = at_once + 1 if self.now - before < 1e-6 else 0
            assert at_once < MOST_AT_ONCE, f'{self.now:.3f} s: {at_once} calls, and no end'
            call()
        return True
