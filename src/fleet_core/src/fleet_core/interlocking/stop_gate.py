"""The last gate that each route passes. A stop closes the gate at once, from any thread."""
from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import Iterator, Sequence


class StopGate:
    """While the gate is closed, only empty routes pass, regardless of their time and origin.

    A stop closes the gate before the empty routes are sent. A route may be decided before the stop
    and, after a slow disk or a queue, arrive here only after the stop. The gate holds it back.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._is_closed = False
        self._stops = 0

    @property
    def is_closed(self) -> bool:
        """Whether each route with edges is held back."""
        return self._is_closed

    @property
    def ticket(self) -> int:
        """The number of stops so far. A person who resumes the fleet knows only of these stops."""
        return self._stops

    def close(self) -> None:
        """Stops the fleet now. Waits only for a route that is passing at this moment."""
        with self._lock:
            self._stops += 1
            self._is_closed = True

    def open(self, ticket: int) -> bool:
        """Opens the gate, unless there was a stop after this ticket. Returns whether the gate
        opened.
        """
        with self._lock:
            if ticket != self._stops:
                return False
            self._is_closed = False
            return True

    @contextmanager
    def passage(self, edges: Sequence[int]) -> Iterator[bool]:
        """Yields whether a route over these edges may be sent. Until it is sent, stops must wait.

        An empty route passes without waiting, because it is a stop.
        """
        if not edges:
            yield True
            return
        with self._lock:
            yield not self._is_closed
