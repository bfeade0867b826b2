"""One clock for all that happens in a model, each thing at its time."""
from __future__ import annotations

import heapq
from typing import Callable, List, Tuple


class Timeline:
    """Calls that are due at some time (s); those due at one time in the order of asking."""

    def __init__(self, now: float) -> None:
        self.now = now
        self._due: List[Tuple[float, int, Callable[[], None]]] = []
        self._count = 0

    def later(self, seconds: float, call: Callable[[], None]) -> None:
        """Calls in a while."""
        self._count += 1
        heapq.heappush(self._due, (self.now + seconds, self._count, call))

    def every(self, period: float, call: Callable[[], None]) -> None:
        """Calls again and again, for the first time at once."""
        def again() -> None:
            self.later(period, again)
            call()
        self.later(0.0, again)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Lets time pass; whether the condition came to hold."""
        end = self.now + seconds
        while not until():
            if not self._due or self._due[0][0] > end:
                self.now = end
                return False
            self.now, _, call = heapq.heappop(self._due)
            call()
        return True
