"""What runs the simulation: one thread, one selector, one simulated clock.

The loop sleeps until a socket is ready or the clock's next callback is due; wall time times the
speed factor is simulated time. What a client sends counts from the robot's next cycle on, and the
clock goes there at once: no client waits, and a client that answers within a cycle finds the same
times in every run.
"""
from __future__ import annotations

import contextlib
import math
import selectors
import socket
import time
from collections import deque
from typing import Callable, Deque, List

from omron_ld90_sim.clock import Clock

INPUT_CYCLE = 0.02      # s of wall time in which what comes in counts as simultaneous, at most
LONGEST_INPUT_CYCLE = 0.1   # so many s of the robot's clock
LONGEST_SLEEP = 3600.0  # s, more than a selector may be asked for is an error


class Loop:
    """Runs sockets and the clock."""

    def __init__(self, clock: Clock, speed: float) -> None:
        self.clock = clock
        self.set_speed(speed)
        self.selector = selectors.DefaultSelector()
        self._wake_read, self._wake_write = socket.socketpair()
        self._wake_read.setblocking(False)
        self.selector.register(self._wake_read, selectors.EVENT_READ, self._woken)
        self._calls: Deque[Callable[[], None]] = deque()
        self._stopped = False
        self.after_step: List[Callable[[], None]] = []

    def set_speed(self, speed: float) -> None:
        """How many times as fast as ours its clock runs from now on; not from another thread."""
        self.speed = speed
        self._cycle = min(INPUT_CYCLE * speed, LONGEST_INPUT_CYCLE)
        self._start = time.monotonic() - self.clock.now / speed

    def _simulated_now(self) -> float:
        return (time.monotonic() - self._start) * self.speed

    def run(self) -> None:
        """Runs until `stop`."""
        self.set_speed(self.speed)     # from now on
        while not self._stopped:
            due = self.clock.next_time
            timeout = None
            if due is not None:
                timeout = (due - self._simulated_now()) / self.speed
                timeout = min(max(timeout, 0.0), LONGEST_SLEEP)
            ready = self.selector.select(timeout)
            now = self._simulated_now()
            self.clock.advance(math.ceil(now / self._cycle) * self._cycle if ready else now)
            for key, mask in ready:
                key.data(mask)
            for callback in self.after_step:
                callback()

    def call(self, function: Callable[[], None]) -> None:
        """Has the loop's thread call `function` soon; safe from any thread."""
        self._calls.append(function)
        self._wake_write.send(b'.')

    def _woken(self, mask: int) -> None:
        self._wake_read.recv(4096)
        for _ in range(len(self._calls)):   # what these ask for waits for the next round
            self._calls.popleft()()

    def stop(self) -> None:
        """Ends `run`; safe from any thread, from a signal handler, early and twice."""
        self._stopped = True
        with contextlib.suppress(OSError):      # the loop may have ended and closed already
            self._wake_write.send(b'.')

    def close(self) -> None:
        """Frees the loop's own sockets and what is still registered."""
        for key in list(self.selector.get_map().values()):
            if isinstance(key.fileobj, socket.socket):
                key.fileobj.close()
        self.selector.close()
        self._wake_read.close()
        self._wake_write.close()
