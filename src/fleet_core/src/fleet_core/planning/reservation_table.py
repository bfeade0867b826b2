"""The reservation table: for each robot type, what each robot with a plan blocks, and when."""
from __future__ import annotations

from bisect import bisect_right
from functools import partial
from math import inf
from typing import Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.planning.blocking import Block, Blocking
from fleet_core.planning.later_bookings import Booked, LaterBookings
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.plans import Drive, end_of
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.slots import Booking, Busy, Slots, merge


class TakenOut(NamedTuple):
    """The state of the reservation table before robots were taken out of it."""

    booked: Dict[str, Booked]
    touched: Dict[str, List[Tuple[Slots, Iterable[int]]]]
    before: List[Tuple[Slots, Dict[int, Tuple[List[Booking], Optional[Busy]]]]]
    """For all slots in which one of these robots is booked: the bookings, and the merged times."""


class ReservationTable:
    """Bookings of many robots. Each robot is booked by name, and its bookings can be removed.

    It answers for each robot type at which times a slot is blocked. All searches for paths use it.

    It has many methods because one class makes, finds and removes the bookings.
    """

    def __init__(self, network: RoadNetwork, clearance: float, kinds: Iterable[RobotType]) -> None:
        self.network = network
        self.clearance = clearance
        self.kinds: Tuple[RobotType, ...] = tuple(dict.fromkeys(kinds))
        self.blocking: Dict[Tuple[RobotType, RobotType], Blocking] = {
            (moving, observer): Blocking(network, moving, observer, clearance)
            for moving in self.kinds for observer in self.kinds}
        self.slots: Dict[RobotType, Slots] = {}
        self.booked: Dict[str, Booked] = {}
        self._touched: Dict[str, List[Tuple[Slots, Iterable[int]]]] = {}
        self._placed: Dict[str, Dict[RobotType, List[Tuple[int, float]]]] = {}
        self._later = LaterBookings(network, self.blocking, {})
        self.clear()

    def clear(self) -> None:
        """Removes the bookings of all robots."""
        self.slots = {kind: Slots(self.network.drives, self.network.vertices)
                      for kind in self.kinds}
        self.booked = {}
        self._touched = {}
        self._placed = {}
        self._later = LaterBookings(self.network, self.blocking, {})

    @property
    def is_empty(self) -> bool:
        """Whether no robot is booked."""
        return not self.booked and not self._placed

    def prepare(self) -> None:
        """Computes in advance what depends only on the graph and its closed edges."""
        for kind in self.kinds:
            self.network.prepared(kind)
        for blocking in self.blocking.values():
            blocking.prepare()

    def book(self, robot: str, kind: RobotType, vertex: int, plan: Sequence[Drive],
             mid_edge: Optional[MidEdgePosition] = None, until: float = inf, held: int = 0) -> None:
        """Books a robot that stands at `vertex`, or `mid_edge`, and then follows its plan.

        After the plan it stands at the end of its plan until the time `until`. It holds the first
        `held` drives from now on: another robot may pass there only after this robot, even if it
        would have enough time before. The robot must not have bookings yet.
        """
        booked = self.state(kind, vertex, plan, mid_edge, until, held)
        self.booked[robot] = booked
        self._touched[robot] = []
        for observer in self.kinds:
            slots, blocking = self.slots[observer], self.blocking[kind, observer]
            touched: List[int] = []
            waits = booked.points.get(observer)
            since, at = -inf, vertex
            for number, (drive, start, end, begun) in enumerate(plan):
                if start > since and (not begun or mid_edge):
                    for slot, lead in blocking.wait(at) if waits is None else waits:
                        slots.add(slot, since - lead, start, robot, touched)
                blocks: Iterable[Block] = blocking.drive(drive)
                if begun:
                    blocks = _remainder_of(blocks, begun)
                if number < held:
                    for slot, clear, _ in blocks:
                        slots.add(slot, -inf, start + clear * (end - start), robot, touched)
                else:
                    slots.add_drive(blocks, start, end - start, robot, touched)
                waits, since, at = None, end, self.network.origin[drive ^ 1]
            for slot, lead in blocking.wait(at) if waits is None else waits:
                slots.add(slot, since - lead, until, robot, touched)
            self._touched[robot].append((slots, touched))
            slots.horizon = max(slots.horizon, since, until if until < inf else since)

    def state(self, kind: RobotType, vertex: int, plan: Sequence[Drive],
              mid_edge: Optional[MidEdgePosition] = None, until: float = inf,
              held: int = 0) -> Booked:
        """Returns the state of a robot, as `book` stores it."""
        points = {} if mid_edge is None else {
            observer: self.at_point(kind, observer, mid_edge) for observer in self.kinds}
        return Booked(kind, vertex, plan, mid_edge, points, until, held)

    def book_later(self, robots: Mapping[str, Booked]) -> None:
        """Books robots like `book`, but makes the bookings of a slot when the slot is first read.

        It can be called once after each `clear`.
        """
        self._later = LaterBookings(self.network, self.blocking, robots)
        self.booked.update(robots)
        for observer, slots in self.slots.items():
            slots.book_later(partial(self._later.row, observer))
            for booked in robots.values():
                since = end_of(booked.plan) if booked.plan else -inf
                slots.horizon = max(slots.horizon, since,
                                    booked.until if booked.until < inf else since)

    def _settle(self, robot: str) -> None:
        """Makes all bookings of a robot that were left for later."""
        if robot not in self._later:
            return
        self._touched[robot] = []
        for observer, slots in self.slots.items():
            touched = self._later.slots(robot, observer)
            for slot in touched:
                slots.row(slot)
            self._touched[robot].append((slots, touched))
        self._later.drop(robot)

    def book_places(self, robot: str, kind: RobotType, places: Iterable[int],
                    areas: Iterable[Area] = ()) -> None:
        """Books for ever a robot that may be anywhere on these places and areas."""
        self._touched[robot] = []
        self._placed[robot] = {}
        for observer in self.kinds:
            blocking, slots = self.blocking[kind, observer], self.slots[observer]
            touched: List[int] = []
            blocked = [block for place in places for block in blocking.wait(place)]
            for area in areas:
                distance = kind.reach + observer.reach + self.clearance + area.radius
                blocked += blocking.beside(self.network.exclusions.kept_free(
                    area.line, distance, area.radius + kind.nearness))
            for slot, _ in blocked:
                slots.add(slot, -inf, inf, robot, touched)
            self._touched[robot].append((slots, touched))
            self._placed[robot][observer] = blocked

    def bookings_of(self, robot: str, observer: RobotType) -> Dict[int, List[Booking]]:
        """Returns the bookings of one robot for an observer of one type, by slot."""
        self._settle(robot)
        slots = self.slots[observer]
        return {slot: [b for b in slots.row(slot) if b[2] == robot]
                for of, touched in self._touched[robot] if of is slots for slot in touched}

    def cancel(self, robot: str) -> None:
        """Removes the bookings of a robot. Does nothing if it is not booked."""
        self.booked.pop(robot, None)
        self._placed.pop(robot, None)
        gone = {robot}
        if robot in self._later:
            for observer, slots in self.slots.items():
                for slot in self._later.slots(robot, observer):
                    if slots.is_made(slot):
                        slots.take_out(slot, gone)
            self._later.drop(robot)
        for slots, touched in self._touched.pop(robot, ()):
            for slot in touched:
                slots.take_out(slot, gone)

    def take_out(self, robots: Sequence[str]) -> TakenOut:
        """Removes the bookings of several robots. `put_back` can restore them quickly.

        All these robots must be booked.
        """
        gone = set(robots)
        for robot in robots:
            self._settle(robot)
        booked = {robot: self.booked.pop(robot) for robot in robots}
        touched = {robot: self._touched.pop(robot) for robot in robots}
        before = []
        for slots in self.slots.values():
            kept = {slot: (slots.row(slot), slots.merged[slot]) for per_robot in touched.values()
                    for of, slots_of in per_robot if of is slots for slot in slots_of}
            for slot in kept:  # new lists: the old ones stay unchanged
                slots.take_out(slot, gone)
            before.append((slots, kept))
        return TakenOut(booked, touched, before)

    def put_back(self, taken: TakenOut) -> None:
        """Restores the bookings that `take_out` removed, and drops newer ones of these robots.

        No other robot may have been booked or removed in between.
        """
        gone = set(taken.booked)
        since = [entry for robot in gone for entry in self._touched.pop(robot, ())]
        for slots, kept in taken.before:
            for slot in {slot for of, slots_of in since if of is slots for slot in slots_of}:
                if slot not in kept:
                    slots.take_out(slot, gone)
            for slot, (old, busy) in kept.items():
                slots.replace(slot, old, busy)
        self.booked.update(taken.booked)
        self._touched.update(taken.touched)

    def arrivals(self, kind: RobotType, mid_edge: MidEdgePosition,
                 ready: float) -> List[Tuple[int, float, int, float]]:
        """Returns the first drives of a robot that is not booked and stands between two vertices.

        There is one entry for each time in which one of its drives is free: the drive, when it may
        begin, the vertex at its end, and when the robot arrives there. The robot must leave before
        another robot passes its point.
        """
        found = []
        leave = min((start for _, start in self.passing(kind, mid_edge)), default=inf)
        for drive, vertex, seconds in mid_edge.exits(self.network, kind):
            starts, ends = merge(self.against_rest(kind, mid_edge, drive))
            gap, begin = bisect_right(ends, ready), ready
            while begin <= leave:
                if begin <= starts[gap]:
                    found.append((drive, begin, vertex, begin + seconds))
                if gap == len(ends):
                    break
                begin = ends[gap]
                gap += 1
        return found

    def against_rest(self, kind: RobotType, mid_edge: MidEdgePosition,
                     drive: int) -> List[Booking]:
        """Returns the bookings that keep a robot, which stands between two vertices, from driving
        to the end of a drive.

        Bookings are made for whole drives. A booking that concerns only the part of the drive
        behind the robot is ignored.
        """
        found: List[Booking] = []
        behind = mid_edge.behind(drive) * self.network.times(kind)[drive]
        for robot, begin, end, blocks in self._activities(kind):
            for slot, lead in blocks:
                if slot == drive and lead > behind:
                    found.append((begin - (lead - behind), end, robot))
        return found

    def passing(self, kind: RobotType,
                mid_edge: MidEdgePosition) -> Iterator[Tuple[str, float]]:
        """Yields the robots that pass the point of `mid_edge`, and when each passing drive begins.
        """
        for moving in self.kinds:
            places = self.places_near(kind, moving, mid_edge)
            for robot, booked in self.booked.items():
                if booked.kind is moving or booked.kind == moving:
                    for drive in booked.plan:
                        if self.network.vertices + (drive.drive >> 1) in places:
                            yield robot, drive.start

    def _activities(self, observer: RobotType) -> Iterator[
            Tuple[str, float, float, Iterable[Tuple[int, float]]]]:
        """Yields each wait and drive of each robot: robot, begin, end, blocked slots with leads."""
        for robot, (kind, vertex, plan, mid_edge, points, until, held) in self.booked.items():
            blocking = self.blocking[kind, observer]
            waits: Iterable[Tuple[int, float]] = (
                blocking.wait(vertex) if mid_edge is None else points[observer])
            since = -inf
            for number, (drive, start, end, begun) in enumerate(plan):
                if start > since and (not begun or mid_edge):
                    yield robot, since, start, waits
                begin = -inf if number < held else start
                for slot, clear, lead in _remainder_of(blocking.drive(drive), begun):
                    yield robot, begin, start + clear * (end - start), [(slot, lead)]
                waits, since = blocking.wait(self.network.origin[drive ^ 1]), end
            yield robot, since, until, waits
        for robot, placed in self._placed.items():
            yield robot, -inf, inf, placed[observer]

    def at_point(self, kind: RobotType, observer: RobotType,
                 mid_edge: MidEdgePosition) -> List[Tuple[int, float]]:
        """Returns (slot, lead) for each slot that a robot between two vertices blocks."""
        return self.blocking[kind, observer].beside(self.places_near(kind, observer, mid_edge))

    def places_near(self, kind: RobotType, other: RobotType,
                    mid_edge: MidEdgePosition) -> Dict[int, Tuple[float, float]]:
        """Returns the places that robots of type `other` may not hold while a robot of type `kind`
        stands between two vertices.

        For each edge it returns the part that is too near to the point where the robot stands.
        """
        return self.network.exclusions.kept_free(((mid_edge.x, mid_edge.y),),
                                                 self.apart(kind, other), kind.nearness)

    def apart(self, kind: RobotType, other: RobotType) -> float:
        """Returns the distance (m) that the curves of two robots must keep from each other."""
        return kind.reach + other.reach + self.clearance


def _remainder_of(blocks: Iterable[Block], begun: float) -> List[Block]:
    """Returns the blocks that are left of a drive when the fraction `begun` of it is driven."""
    return [(slot, (clear - begun) / (1.0 - begun), lead)
            for slot, clear, lead in blocks if clear > begun]
