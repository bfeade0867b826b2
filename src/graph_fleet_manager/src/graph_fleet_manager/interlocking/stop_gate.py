"""The last gate in front of every route: a stop closes it at once, from any thread."""
from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import Iterator, Sequence


class StopGate:
    """While it is closed only empty routes pass, regardless of their time and origin.

    A stop closes it before the empty routes are sent. What was decided before the stop, and comes
    out of a hanging disk or a queue after it, is held here.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._is_closed = False
        self._stops = 0

    @property
    def is_closed(self) -> bool:
        """Does no route with edges pass?"""
        return self._is_closed

    @property
    def ticket(self) -> int:
        """The number of stops so far; a person who resumes knows of these only."""
        return self._stops

    def close(self) -> None:
        """The fleet is stopped now. Waits for nothing but a route that passes at this moment."""
        with self._lock:
            self._stops += 1
            self._is_closed = True

    def open(self, ticket: int) -> bool:
        """The fleet goes on, unless it was stopped again since the ticket; tells whether it does.
        """
        with self._lock:
            if ticket != self._stops:
                return False
            self._is_closed = False
            return True

    @contextmanager
    def passage(self, edges: Sequence[int]) -> Iterator[bool]:
        """Whether a route over these edges may be sent now; no stop comes in between.

        An empty route passes without waiting, as a stop must.
        """
        if not edges:
            yield True
            return
        with self._lock:
            yield not self._is_closed
