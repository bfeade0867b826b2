"""The event loop of a node: callbacks leave calls, one thread makes them, and looks at the clock.

A tick comes when it is due, after the calls that waited then: it finds out what is silent, and must
not find silent what still waits to be heard. However many calls come, a tick is never left out.
"""
from __future__ import annotations

import queue
import threading
import time
from typing import Callable, Optional

Call = Callable[[], object]
Clock = Callable[[], float]


class EventLoop:
    """Makes the calls that `put` is given in their order, and `tick` every `period` seconds."""

    def __init__(self, tick: Call, period: float, clock: Clock = time.monotonic) -> None:
        self._tick, self._period, self._clock = tick, period, clock
        self._calls: queue.SimpleQueue[Optional[Call]] = queue.SimpleQueue()
        self._ending = threading.Event()

    def put(self, call: Call) -> None:
        """Leaves a call; from any thread, never waits."""
        self._calls.put(call)

    def put_if_room(self, call: Call, most: int, crowded: Call) -> None:
        """Leaves a call, or waits while more than `most` others do, so that a topic drops some.

        crowded -- is called now and then while it waits
        """
        while self._calls.qsize() > most and not self._ending.wait(self._period):
            crowded()
        self._calls.put(call)

    def end(self) -> None:
        """Makes no further call; `run` returns after the one that it makes now."""
        self._ending.set()
        self._calls.put(None)

    def run(self) -> None:
        """Makes the calls until `end`. What a call raises ends it, too."""
        due = self._clock()
        before: Optional[int] = None  # calls that come before the tick that is due; None: none is
        while not self._ending.is_set():
            now = self._clock()
            if before is None and now >= due:
                before = self._calls.qsize()
            if before == 0:
                before, due = None, (due if now < due + self._period else now) + self._period
                self._tick()
                continue
            try:
                call = self._calls.get(timeout=max(due - now, 0.0))
            except queue.Empty:
                continue
            if before is not None:
                before -= 1
            if call is not None and not self._ending.is_set():
                call()
