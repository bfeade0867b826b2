"""Things that are sent now and arrive later, in virtual time."""
from __future__ import annotations

from typing import Generic, Iterator, List, Tuple, TypeVar

Thing = TypeVar('Thing')


class OnTheWay(Generic[Thing]):
    """Things that have been sent and have not arrived yet, in the order of sending."""

    def __init__(self) -> None:
        self._things: List[Tuple[float, Thing]] = []

    def send(self, thing: Thing, at: float) -> None:
        """Sends a thing that arrives at the virtual time `at`, in s."""
        self._things.append((at, thing))

    def lose(self) -> None:
        """Loses all that has not arrived yet."""
        self._things = []

    def has_arrived(self, now: float) -> bool:
        """Returns whether anything has arrived by now."""
        return any(at <= now for at, _ in self._things)

    def arrived(self, now: float) -> Iterator[Thing]:
        """Yields the things that have arrived. A thing that is sent meanwhile is yielded by a later
        call.
        """
        things, self._things = self._things, []
        for at, thing in things:
            if at <= now:
                yield thing
            else:
                self._things.append((at, thing))
