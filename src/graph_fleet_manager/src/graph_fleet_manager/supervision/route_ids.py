"""Route ids that never repeat, not even while the disk cannot be written."""
from __future__ import annotations

import random
from typing import Dict

from graph_fleet_manager.supervision.journal import Journal

RESERVED = 10000      # number of ids that are stored as given before they are given
_MOST = 2 ** 30 - 1   # an id is an int32; higher ids are for stops that bypass the supervisor
_LARGEST = 2 ** 31 - 1
_NAME = 'route_id'


def is_past(route_id: int) -> bool:
    """Is this the id of a stop that bypassed the supervisor, because it hung or did not run?"""
    return route_id > _MOST


def past_id() -> int:
    """A new id for such a stop."""
    return random.randint(_MOST + 1, _LARGEST)


class RouteIds:
    """Gives ids beyond all that the journal has as given.

    The constructor raises JournalUnavailable.

    before   -- number of ids that were given, or were reserved, before this start
    reserved -- number of ids that were given, or may be given without storing again
    """

    def __init__(self, journal: Journal) -> None:
        self._given = self.before = journal.value(_NAME)
        self.reserved = self._given + RESERVED
        journal.store(values=self.values)

    def is_later(self, route_id: int, last: int) -> bool:
        """Was this id given by a supervisor with a later journal?

        An id far beyond all given ids belongs to another program.

        last -- the highest id that the robot was given, by this journal
        """
        return last < route_id <= self._given + 2 * RESERVED and not is_past(route_id)

    def skip(self, route_id: int) -> None:
        """Skips the ids up to this one: they were given, although the journal does not have them.
        """
        self._given = max(self._given, route_id) + RESERVED
        self.reserved = self._given + RESERVED

    @property
    def values(self) -> Dict[str, int]:
        """The numbers to be stored in the journal."""
        return {_NAME: self.reserved}

    def __call__(self) -> int:
        """Returns an id that was never given before."""
        self._given += 1
        if self.reserved - self._given < RESERVED // 2:
            self.reserved = self._given + RESERVED
        return (self._given - 1) % _MOST + 1
