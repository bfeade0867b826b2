"""Ids of routes, which never repeat, not even where the disk cannot be written for a while."""
from __future__ import annotations

import random
from typing import Dict

from graph_fleet_manager.supervision.journal import Journal

RESERVED = 10000      # ids that are on the disk as given before they are
_MOST = 2 ** 30 - 1   # an id is an int32; those above are given past the supervisor
_LARGEST = 2 ** 31 - 1
_NAME = 'route_id'


def is_past(route_id: int) -> bool:
    """Is this the id of a stop that was given past a supervisor, as it hung or did not run?"""
    return route_id > _MOST


def past_id() -> int:
    """An id for such a stop."""
    return random.randint(_MOST + 1, _LARGEST)


class RouteIds:
    """Gives ids beyond all that the journal has as given; raises JournalUnavailable at the start.

    reserved -- how many were ever given, or may be given from now on
    """

    def __init__(self, journal: Journal) -> None:
        self._given = journal.value(_NAME)
        self.reserved = self._given + RESERVED
        journal.store(values=self.values)

    def is_unknown(self, route_id: int) -> bool:
        """Was this id given by a supervisor with a later journal?

        An id far beyond all that were given is one of another program.
        """
        return self._given < route_id <= self._given + 2 * RESERVED and not is_past(route_id)

    def skip(self, route_id: int) -> None:
        """Ids up to this one were given, though the journal does not have that."""
        self._given = max(self._given, route_id) + RESERVED
        self.reserved = self._given + RESERVED

    @property
    def values(self) -> Dict[str, int]:
        """What the journal is to store."""
        return {_NAME: self.reserved}

    def __call__(self) -> int:
        """An id that was never given before."""
        self._given += 1
        if self.reserved - self._given < RESERVED // 2:
            self.reserved = self._given + RESERVED
        return (self._given - 1) % _MOST + 1
