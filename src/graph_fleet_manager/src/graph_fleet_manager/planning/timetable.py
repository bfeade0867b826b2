"""Who blocks what and when: the bookings of all robots that have a plan, as each type sees them."""
from __future__ import annotations

import math
from typing import Dict, Iterable, List, Optional, Sequence, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.planning.blocking import Blocking
from graph_fleet_manager.planning.plans import Drive
from graph_fleet_manager.planning.road_network import RoadNetwork

Busy = Tuple[Sequence[float], Sequence[float]]
"""Beginnings and ends of the times at which a slot is blocked: ascending, without overlaps."""

_NEVER: Busy = ((), ())
_Booking = Tuple[float, float, str]


class Slots:
    """The bookings as one robot type sees them: when it may begin each drive, or wait."""

    def __init__(self, count: int) -> None:
        self.bookings: List[List[_Booking]] = [[] for _ in range(count)]
        self.merged: List[Optional[Busy]] = [_NEVER] * count

    def busy(self, slot: int) -> Busy:
        """When `slot` is blocked. At the very ends of these times it is free."""
        busy = self.merged[slot]
        if busy is None:
            busy = self.merged[slot] = merge(self.bookings[slot])
        return busy


class Timetable:
    """Bookings of many robots; each robot is booked by name and can be taken out again."""

    def __init__(self, network: RoadNetwork, clearance: float, kinds: Iterable[RobotType]) -> None:
        self.network = network
        self.clearance = clearance
        self.kinds: Tuple[RobotType, ...] = tuple(dict.fromkeys(kinds))
        self.blocking: Dict[Tuple[RobotType, RobotType], Blocking] = {
            (mover, observer): Blocking(network, mover, observer, clearance)
            for mover in self.kinds for observer in self.kinds}
        self.clear()

    def clear(self) -> None:
        """Takes everybody out."""
        count = self.network.drives + self.network.vertices
        self.slots: Dict[RobotType, Slots] = {kind: Slots(count) for kind in self.kinds}
        self._booked: Dict[str, List[Tuple[RobotType, int]]] = {}

    def prepare(self) -> None:
        """Computes from geometry what can be computed beforehand."""
        for blocking in self.blocking.values():
            blocking.prepare()

    def book(self, robot: str, kind: RobotType, vertex: int, plan: Sequence[Drive]) -> None:
        """Books a robot that stands at `vertex` till its plan begins and then follows the plan.

        A plan that begins within a drive needs no vertex before it.
        """
        for observer in self.kinds:
            self._book_for(robot, kind, observer, vertex, plan)

    def book_wait(self, robot: str, kind: RobotType, vertex: int, begin: float,
                  end: float) -> None:
        """Books a robot that waits at a vertex for some time."""
        for observer in self.kinds:
            add = self._adder(robot, observer)
            for slot, lead in self.blocking[kind, observer].wait(vertex):
                add(slot, begin - lead, end)

    def book_places(self, robot: str, kind: RobotType, places: Iterable[int]) -> None:
        """Books for ever a robot that may be anywhere on these places."""
        for observer in self.kinds:
            add = self._adder(robot, observer)
            for place in places:
                for slot, _ in self.blocking[kind, observer].of_place(place):
                    add(slot, -math.inf, math.inf)

    def book_point(self, robot: str, kind: RobotType, x: float, y: float, end: float) -> None:
        """Books a robot that stands between vertices until `end`."""
        for observer in self.kinds:
            add = self._adder(robot, observer)
            distance = kind.reach + observer.reach + self.clearance
            for slot, _ in self.blocking[kind, observer].around_point(x, y, distance):
                add(slot, -math.inf, end)

    def cancel(self, robot: str) -> None:
        """Takes a robot out; one that is not booked is none."""
        for observer, slot in set(self._booked.pop(robot, ())):
            slots = self.slots[observer]
            slots.bookings[slot] = [b for b in slots.bookings[slot] if b[2] != robot]
            slots.merged[slot] = None

    def _adder(self, robot: str, observer: RobotType):
        slots = self.slots[observer]
        touched = self._booked.setdefault(robot, [])

        def add(slot: int, begin: float, end: float) -> None:
            slots.bookings[slot].append((begin, end, robot))
            slots.merged[slot] = None
            touched.append((observer, slot))
        return add

    def _book_for(self, robot: str, kind: RobotType, observer: RobotType, vertex: int,
                  plan: Sequence[Drive]) -> None:
        blocking = self.blocking[kind, observer]
        slots = self.slots[observer]
        bookings, merged = slots.bookings, slots.merged
        touched: List[int] = []
        touch = touched.append
        since = -math.inf
        for drive, start, end, begun in plan:
            if start > since and not begun:
                for slot, lead in blocking.wait(vertex):
                    bookings[slot].append((since - lead, start, robot))
                    merged[slot] = None
                    touch(slot)
            seconds = end - start
            blocks = blocking.drive(drive)
            if begun:
                blocks = [(slot, (clear - begun) / (1.0 - begun), lead)
                          for slot, clear, lead in blocks if clear > begun]
            for slot, clear, lead in blocks:
                bookings[slot].append((start - lead, start + clear * seconds, robot))
                merged[slot] = None
                touch(slot)
            vertex, since = self.network.origin[drive ^ 1], end
        for slot, lead in blocking.wait(vertex):
            bookings[slot].append((since - lead, math.inf, robot))
            merged[slot] = None
            touch(slot)
        self._booked.setdefault(robot, []).extend((observer, slot) for slot in touched)


def merge(bookings: Sequence[_Booking]) -> Busy:
    """The times that any of the bookings covers."""
    if not bookings:
        return _NEVER
    if len(bookings) == 1:
        begin, end, _ = bookings[0]
        return (begin,), (end,)
    starts: List[float] = []
    ends: List[float] = []
    last = -math.inf
    for begin, end, _ in sorted(bookings):
        if begin < last or not ends:
            if not ends:
                starts.append(begin)
                ends.append(end)
                last = end
            elif end > last:
                ends[-1] = last = end
        else:
            starts.append(begin)
            ends.append(end)
            last = end
    return starts, ends


