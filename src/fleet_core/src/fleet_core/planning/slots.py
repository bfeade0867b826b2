"""The bookings of each slot, and the times at which it is blocked, for one robot type."""
from __future__ import annotations

from math import inf
from typing import AbstractSet, Callable, Iterable, List, Optional, Sequence, Tuple

from fleet_core.planning.blocking import Block

Busy = Tuple[Sequence[float], Sequence[float]]
"""Beginnings and ends of the times at which a slot is blocked: ascending, without overlaps.

The last beginning is infinity. So beginning k is the end of the free time before the k-th block.
"""

_NEVER: Busy = ((inf,), ())
Booking = Tuple[float, float, str]
"""Begin, end, robot. The robot blocks the slot from begin to end without a break."""


def _nobody(_: int) -> List[Booking]:
    return []


class Slots:
    """The bookings of all slots, as they apply to robots of one type."""

    def __init__(self, drives: int, vertices: int) -> None:
        self.drives = drives
        """Number of slots for drives. The slots for vertices follow them."""
        self.merged: List[Optional[Busy]] = [_NEVER] * (drives + vertices)
        self.horizon = 0.0
        """Time after which nothing changes any more."""
        self._rows: List[Optional[List[Booking]]] = [None] * (drives + vertices)
        self._later: Callable[[int], List[Booking]] = _nobody

    def book_later(self, bookings: Callable[[int], List[Booking]]) -> None:
        """Adds bookings that are made for each slot when the slot is first read.

        bookings -- returns the bookings of a slot
        """
        before, self._rows = self._rows, [None] * len(self._rows)
        self._later, self.merged = bookings, [None] * len(self._rows)
        for slot, row in enumerate(before):
            if row:
                self._rows[slot] = row + bookings(slot)

    def row(self, slot: int) -> List[Booking]:
        """Returns the bookings of a slot, in the order in which they were made."""
        row = self._rows[slot]
        if row is None:
            row = self._rows[slot] = self._later(slot)
        return row

    def is_made(self, slot: int) -> bool:
        """Returns whether the bookings of a slot are made already."""
        return self._rows[slot] is not None

    def replace(self, slot: int, row: List[Booking], busy: Optional[Busy] = None) -> None:
        """Replaces the bookings of a slot; `busy` has their merged times, if these are known."""
        self._rows[slot] = row
        self.merged[slot] = busy

    def take_out(self, slot: int, robots: AbstractSet[str]) -> None:
        """Removes the bookings of these robots from a slot."""
        self.replace(slot, [b for b in self.row(slot) if b[2] not in robots])

    def add(self, slot: int, begin: float, end: float, robot: str, touched: List[int]) -> None:
        """Books a slot for a robot. Adds the slot to `touched` if this makes a new booking."""
        row = self.row(slot)
        if extend(row, begin, end, robot):
            return
        row.append((begin, end, robot))
        self.merged[slot] = None
        touched.append(slot)

    def add_drive(self, blocks: Iterable[Block], start: float, seconds: float, robot: str,
                  touched: List[int]) -> None:
        """Books all slots that a drive blocks. Repeats the code of `add`, because it runs often."""
        rows, merged = self._rows, self.merged
        for slot, clear, lead in blocks:
            begin = start - lead
            row = rows[slot]
            if row is None:
                row = self.row(slot)
            if row:
                since, until, name = row[-1]
                if name == robot and begin <= until:
                    if since < begin:
                        begin = since
                    # the new end is later than the old one
                    row[-1] = begin, start + clear * seconds, robot
                    continue
            row.append((begin, start + clear * seconds, robot))
            merged[slot] = None
            touched.append(slot)

    def busy(self, slot: int) -> Busy:
        """Returns the times at which a slot is blocked.

        At the beginning and at the end of such a period, the slot is free.
        """
        busy = self.merged[slot]
        if busy is None:
            row = self._rows[slot]  # most slots have a row, and need no call of `row`
            busy = self.merged[slot] = merge(self.row(slot) if row is None else row)
        return busy


def extend(row: List[Booking], begin: float, end: float, robot: str) -> bool:
    """Extends the last booking of a slot if a new booking of the same robot overlaps it.

    Returns whether the booking was extended.
    """
    if not row or row[-1][2] != robot or begin > row[-1][1]:
        return False
    row[-1] = min(row[-1][0], begin), max(row[-1][1], end), robot
    return True


def merge(bookings: Sequence[Booking]) -> Busy:
    """Returns the times that at least one of the bookings covers."""
    count = len(bookings)
    if count == 0:
        return _NEVER
    if count == 1:
        begin, end, _ = bookings[0]
        return (begin, inf), (end,)
    if count == 2:  # most calls have at most two bookings
        one, other = bookings
        if other[0] < one[0]:
            one, other = other, one
        if other[0] >= one[1]:
            return (one[0], other[0], inf), (one[1], other[1])
        return (one[0], inf), (max(one[1], other[1]),)
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
    starts.append(inf)
    return starts, ends
