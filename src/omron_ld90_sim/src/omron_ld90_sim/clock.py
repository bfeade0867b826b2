"""The simulated clock: runs callbacks at points of simulated time, in order.

The wall clock has two uses: it determines how far the loop advances the simulated clock, and
answers contain its date. Everything else in a run depends only on the inputs and their times.
"""
from __future__ import annotations

import heapq
from typing import Callable, List, Optional, Tuple

ROUNDING = 1e-6         # of a period


class Timer:
    """A callback that waits on a `SimClock`. It runs once, unless it is cancelled."""

    def __init__(self, callback: Callable[[], None]) -> None:
        self._callback: Optional[Callable[[], None]] = callback

    @property
    def waiting(self) -> bool:
        """Whether the callback has neither run nor been cancelled."""
        return self._callback is not None

    def cancel(self) -> None:
        """Drops the callback; has no effect after it has run."""
        self._callback = None

    def run(self) -> None:
        """Runs the callback, once."""
        callback, self._callback = self._callback, None
        if callback is not None:
            callback()


class SimClock:
    """Simulated seconds since the start, and the waiting callbacks."""

    def __init__(self) -> None:
        self.now = 0.0
        self._queue: List[Tuple[float, int, Timer]] = []
        self._count = 0

    def at(self, time: float, callback: Callable[[], None]) -> Timer:
        """Runs `callback` at `time` (s), or on the next advance if that time has passed."""
        timer = Timer(callback)
        self._count += 1
        heapq.heappush(self._queue, (max(time, self.now), self._count, timer))
        return timer

    def after(self, delay: float, callback: Callable[[], None]) -> Timer:
        """Runs `callback` in `delay` seconds."""
        return self.at(self.now + delay, callback)

    @property
    def next_time(self) -> Optional[float]:
        """The time of the next callback; None if none is waiting."""
        while self._queue and not self._queue[0][2].waiting:
            heapq.heappop(self._queue)
        return self._queue[0][0] if self._queue else None

    def advance(self, until: float) -> None:
        """Runs all callbacks due up to `until`, in order of time, then sets the time to `until`."""
        while True:
            due = self.next_time
            if due is None or due > until:
                break
            _, _, timer = heapq.heappop(self._queue)
            self.now = max(self.now, due)
            timer.run()
        self.now = max(self.now, until)


class Ticker:
    """Calls back at every whole multiple of `period` seconds, so it does not drift.

    The periods are counted from the start of the clock. So the time at which a client connects has
    no effect on the times of the calls.
    """

    def __init__(self, clock: SimClock, period: float, callback: Callable[[], None]) -> None:
        self._clock, self._period, self._callback = clock, period, callback
        self._count = int(clock.now / period + ROUNDING)
        self._timer = self._arm()

    def _arm(self) -> Timer:
        self._count += 1
        return self._clock.at(self._count * self._period, self._tick)

    def _tick(self) -> None:
        self._timer = self._arm()
        self._callback()

    def stop(self) -> None:
        """Ends the calls."""
        self._timer.cancel()
