"""Runs the simulation with one thread, one selector and one simulated clock.

The loop sleeps until a socket is ready or the clock's next callback is due. Simulated time is wall
time multiplied by the speed factor. Input takes effect at the robot's next cycle; the clock
advances to this cycle at once. So no client waits, and a client that answers within a cycle sees
the same times in every run. If inputs take long, for example because many robots plan, inputs and
clock take turns.
"""
from __future__ import annotations

import contextlib
import math
import selectors
import socket
import time
from collections import deque
from typing import Callable, Deque, List, Tuple

from omron_ld90_sim.clock import SimClock

INPUT_CYCLE = 0.02      # s of wall time; inputs within such a cycle take effect together
LONGEST_INPUT_CYCLE = 0.1   # s of the robot's clock; no cycle is longer than this
LONGEST_ROUND = 0.1     # s of wall time for inputs, after which the clock has its turn
LONGEST_SLEEP = 3600.0  # s; a selector does not accept much longer times


class Loop:
    """Runs sockets and the clock."""

    def __init__(self, clock: SimClock, speed: float) -> None:
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
        """Sets the clock's speed as a factor of real time; not safe from another thread."""
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
            self._serve(ready)
            for callback in self.after_step:
                callback()

    def _serve(self, ready: List[Tuple[selectors.SelectorKey, int]]) -> None:
        """Handles the inputs that are ready, for LONGEST_ROUND at most; the rest stays ready."""
        until = time.monotonic() + LONGEST_ROUND
        for key, mask in ready:
            key.data(mask)
            if time.monotonic() > until:
                return

    def call(self, function: Callable[[], None]) -> None:
        """Makes the loop's thread call `function` soon; safe from any thread."""
        self._calls.append(function)
        self._wake_write.send(b'.')

    def _woken(self, mask: int) -> None:
        self._wake_read.recv(4096)
        for _ in range(len(self._calls)):   # calls added meanwhile wait for the next round
            self._calls.popleft()()

    def stop(self) -> None:
        """Ends `run`. Any thread or signal handler may call it, also before `run` and repeatedly.
        """
        self._stopped = True
        with contextlib.suppress(OSError):      # the loop may have ended and closed already
            self._wake_write.send(b'.')

    def close(self) -> None:
        """Closes the loop's own sockets and all registered ones."""
        for key in list(self.selector.get_map().values()):
            if isinstance(key.fileobj, socket.socket):
                key.fileobj.close()
        self.selector.close()
        self._wake_read.close()
        self._wake_write.close()
