"""The event loop of a node: callbacks queue calls, and one thread makes the calls and the ticks.

When a tick becomes due, the calls that are already queued run first: a tick looks for missing
messages, which may be among these calls. Calls that are queued later cannot delay the tick.
"""
from __future__ import annotations

import queue
import threading
import time
from typing import Callable, Optional

Call = Callable[[], object]
Clock = Callable[[], float]


class EventLoop:
    """Makes the queued calls in order, and calls `tick` every `period` seconds."""

    def __init__(self, tick: Call, period: float, clock: Clock = time.monotonic) -> None:
        self._tick, self._period, self._clock = tick, period, clock
        self._calls: queue.SimpleQueue[Optional[Call]] = queue.SimpleQueue()
        self._ending = threading.Event()

    def put(self, call: Call) -> None:
        """Queues a call. Any thread may call this; it never waits."""
        self._calls.put(call)

    def put_if_room(self, call: Call, most: int, crowded: Call) -> None:
        """Queues a call. Waits while more than `most` calls are queued.

        If a topic's callback waits here, rospy drops messages of this topic.

        crowded -- called repeatedly during the wait
        """
        while self._calls.qsize() > most and not self._ending.wait(self._period):
            crowded()
        self._calls.put(call)

    def end(self) -> None:
        """Ends the loop: `run` returns after the present call."""
        self._ending.set()
        self._calls.put(None)

    def run(self) -> None:
        """Makes the calls until `end`. An exception of a call also ends the loop."""
        due = self._clock()
        before: Optional[int] = None  # calls to make before the due tick; None: no tick is due
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
