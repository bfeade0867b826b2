"""The bookings of each slot, and the times at which it is blocked, for one robot type."""
from __future__ import annotations

from math import inf
from typing import Iterable, List, Optional, Sequence, Tuple

from fleet_core.planning.blocking import Block

Busy = Tuple[Sequence[float], Sequence[float]]
"""Beginnings and ends of the times at which a slot is blocked: ascending, without overlaps."""

_NEVER: Busy = ((), ())
Booking = Tuple[float, float, str]
"""Begin, end, robot. One booking is a time in which one robot blocks without a break."""


class Slots:
    """The bookings as one robot type sees them: when it may begin each drive, or wait."""

    def __init__(self, drives: int, vertices: int) -> None:
        self.drives = drives
        """Number of slots for drives. The slots for vertices follow them."""
        self.bookings: List[List[Booking]] = [[] for _ in range(drives + vertices)]
        self.merged: List[Optional[Busy]] = [_NEVER] * (drives + vertices)
        self.horizon = 0.0
        """Time after which nothing changes any more."""

    def add(self, slot: int, begin: float, end: float, robot: str, touched: List[int]) -> None:
        """Books a slot for a robot. Adds the slot to `touched` if it gets a further booking."""
        row = self.bookings[slot]
        if row:
            since, until, name = row[-1]
            if name == robot and begin <= until:
                row[-1] = min(since, begin), max(until, end), robot
                return
        row.append((begin, end, robot))
        self.merged[slot] = None
        touched.append(slot)

    def add_drive(self, blocks: Iterable[Block], start: float, seconds: float, robot: str,
                  touched: List[int]) -> None:
        """Books all blocks of a drive. It is `add` for each, written out because it runs so often.
        """
        bookings, merged = self.bookings, self.merged
        for slot, clear, lead in blocks:
            begin = start - lead
            row = bookings[slot]
            if row:
                since, until, name = row[-1]
                if name == robot and begin <= until:
                    if since < begin:
                        begin = since
                    # its end is later than that of the booking before
                    row[-1] = begin, start + clear * seconds, robot
                    continue
            row.append((begin, start + clear * seconds, robot))
            merged[slot] = None
            touched.append(slot)

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
    if len(bookings) == 2:  # most calls have at most two bookings
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
