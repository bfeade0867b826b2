"""The numbered changes of all robots, so that a reader looks only at robots that have changed."""
from __future__ import annotations

from itertools import takewhile
from typing import Callable, Dict, List


class Changes:
    """The last change of each robot."""

    def __init__(self) -> None:
        self._number = 0
        self._last: Dict[str, int] = {}  # the robot that changed last comes last

    def add(self, name: str) -> None:
        """Notes that a robot has changed."""
        self._number += 1
        self._last.pop(name, None)
        self._last[name] = self._number

    def of(self, name: str) -> int:
        """Returns the number of the last change of a robot; it only grows."""
        return self._last.get(name, 0)

    def follow(self) -> Callable[[], List[str]]:
        """Returns a function that returns the names of the robots changed since its last call."""
        read = 0

        def news() -> List[str]:
            nonlocal read
            names = list(takewhile(lambda name: self._last[name] > read, reversed(self._last)))
            read = self._number
            return names[::-1]
        return news
