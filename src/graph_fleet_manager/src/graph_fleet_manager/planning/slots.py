"""What is booked of each slot, and when it is blocked by that, as one robot type sees it."""
from __future__ import annotations

from math import inf
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple

from graph_fleet_manager.planning.blocking import Block

Busy = Tuple[Sequence[float], Sequence[float]]
"""Beginnings and ends of the times at which a slot is blocked: ascending, without overlaps."""

_NEVER: Busy = ((), ())
Booking = List[Any]
"""Begin, end, robot."""


class Slots:
    """The bookings as one robot type sees them: when it may begin each drive, or wait."""

    def __init__(self, drives: int, vertices: int) -> None:
        self.drives = drives
        """Behind so many slots for drives follow those for vertices."""
        self.bookings: List[List[Booking]] = [[] for _ in range(drives + vertices)]
        self.merged: List[Optional[Busy]] = [_NEVER] * (drives + vertices)
        self.horizon = 0.0
        """After this time nothing changes any more."""

    def add(self, latest: Dict[int, Booking], slot: int, begin: float, end: float,
            robot: str) -> None:
        """Books a slot. What one robot blocks without a break is one booking: it is in `latest`."""
        booking = latest.get(slot)
        if booking is not None and begin <= booking[1]:
            booking[0] = min(booking[0], begin)
            booking[1] = max(booking[1], end)
        else:
            latest[slot] = booking = [begin, end, robot]
            self.bookings[slot].append(booking)
            self.merged[slot] = None

    def add_drive(self, latest: Dict[int, Booking], blocks: Iterable[Block], start: float,
                  seconds: float, robot: str) -> None:
        """Books all that a drive blocks: `add` for each, written out because it runs so often."""
        bookings, merged = self.bookings, self.merged
        for slot, clear, lead in blocks:
            begin = start - lead
            booking = latest.get(slot)
            if booking is None or begin > booking[1]:
                latest[slot] = booking = [begin, start + clear * seconds, robot]
                bookings[slot].append(booking)
                merged[slot] = None
            else:
                booking[1] = start + clear * seconds  # later than what came before it
                if begin < booking[0]:
                    booking[0] = begin

    def is_booked(self, robot: str, slot: int, begin: float, end: float) -> bool:
        """Is a slot booked for a robot at any time between two, or at one within?"""
        return any(since < end and begin < until for since, until, name in self.bookings[slot]
                   if name == robot)

    def busy(self, slot: int) -> Busy:
        """When `slot` is blocked. At the very ends of these times it is free."""
        busy = self.merged[slot]
        if busy is None:
            busy = self.merged[slot] = merge(self.bookings[slot])
        return busy


def merge(bookings: Sequence[Booking]) -> Busy:
    """The times that any of the bookings covers."""
    if not bookings:
        return _NEVER
    if len(bookings) == 1:
        return (bookings[0][0],), (bookings[0][1],)
    if len(bookings) == 2:  # these three make up most of all that is asked for
        one, other = bookings
        if other[0] < one[0]:
            one, other = other, one
        if other[0] >= one[1]:
            return (one[0], other[0]), (one[1], other[1])
        return (one[0],), (max(one[1], other[1]),)
    starts: List[float] = []
    ends: List[float] = []
    last = -inf
    for begin, end, _ in sorted(bookings):
        if begin >= last or not ends:
            starts.append(begin)
            ends.append(end)
            last = end
        elif end > last:
            ends[-1] = last = end
    return starts, ends
