"""Bookings of robots that keep their plans, made for each slot when the slot is first read.

The search for one robot reads few slots, but the kept plans of all other robots block most slots.
So this index stores only which robots use which places. The bookings and their order are the same
as if each robot had been booked immediately.
"""
from __future__ import annotations

from math import inf
from typing import (
    Dict,
    Iterable,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
)

from fleet_core.fleet import RobotType
from fleet_core.planning.blocking import Blocking
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.plans import Drive
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.slots import Booking, extend


class Booked(NamedTuple):
    """The booked state of one robot.

    mid_edge -- where it stands between two vertices; None: it stands at `vertex`
    points   -- by observer, each (slot, lead) that the robot blocks while it stands at `mid_edge`
    until    -- time until which it stands at its end
    held     -- number of drives that it holds from now on
    """

    kind: RobotType
    vertex: int
    plan: Sequence[Drive]
    mid_edge: Optional[MidEdgePosition]
    points: Mapping[RobotType, Sequence[Tuple[int, float]]]
    until: float
    held: int

    def wait(self, number: int) -> Optional[Tuple[float, float]]:
        """Returns the begin and the end of the robot's wait before the drive with this number;
        None: the robot does not wait.

        The number after the last drive stands for the wait at the end.
        """
        since = self.plan[number - 1].end if number else -inf
        if number == len(self.plan):
            return since, self.until
        _, start, _, begun = self.plan[number]
        return (since, start) if start > since and (not begun or self.mid_edge) else None


Times = Tuple[Tuple[float, float], ...]
"""Begin and end of a booking; empty: there is none."""

_Part = Tuple[int, int, float, float]
"""The number of a robot in the order of booking; a step of its plan (even: a wait, odd: a drive);
begin and end of the step.
"""


class LaterBookings:
    """The bookings of some robots, by slot.

    robots -- the booked states by name, in the order in which the robots are booked
    """

    def __init__(self, network: RoadNetwork,
                 blocking: Mapping[Tuple[RobotType, RobotType], Blocking],
                 robots: Mapping[str, Booked]) -> None:
        self._network, self._blocking = network, blocking
        self._names, self._robots = list(robots), list(robots.values())
        self._left = dict(zip(robots, range(len(robots))))
        self._users: Dict[RobotType, List[Optional[List[Tuple[int, int]]]]] = {}
        self._points: Dict[RobotType, Dict[int, List[Tuple[int, float]]]] = {}
        for number, booked in enumerate(self._robots):
            self._add(number, booked)

    def _add(self, robot: int, booked: Booked) -> None:
        network = self._network
        if booked.kind not in self._users:
            self._users[booked.kind] = [None] * (network.vertices + network.drives // 2)
        users = self._users[booked.kind]
        for observer, blocked in booked.points.items():
            points = self._points.setdefault(observer, {})
            for slot, lead in blocked:
                points.setdefault(slot, []).append((robot, lead))
        for number, place in enumerate(_places(booked, network)):
            if place >= 0:
                there = users[place]
                if there is None:
                    users[place] = [(robot, number)]
                else:
                    there.append((robot, number))

    def __contains__(self, name: str) -> bool:
        return name in self._left

    def drop(self, name: str) -> None:
        """Notes that this robot is not booked any more, or that all its bookings are made."""
        self._left.pop(name, None)

    def slots(self, name: str, observer: RobotType) -> Set[int]:
        """Returns all slots that a robot blocks for an observer, and perhaps further slots."""
        booked = self._robots[self._left[name]]
        blocking, vertices = self._blocking[booked.kind, observer], self._network.vertices
        found = {slot for slot, _ in booked.points.get(observer, ())}
        for place in set(_places(booked, self._network)):
            if place >= vertices:
                found.update(slot for slot, _, _ in blocking.drive(2 * (place - vertices)))
            elif place >= 0:
                found.update(slot for slot, _ in blocking.wait(place))
        return found

    def row(self, observer: RobotType, slot: int) -> List[Booking]:
        """Returns the bookings of a slot for an observer, in order."""
        parts = [(robot, 0, *wait) for robot, lead in self._points.get(observer, {}).get(slot, ())
                 for wait in self._wait(robot, 0, lead)]
        is_drive = slot < self._network.drives
        place = self._network.vertices + (slot >> 1) if is_drive else slot - self._network.drives
        seconds = self._blocking[observer, observer].seconds(slot) if is_drive else 0.0
        for kind, users in self._users.items():
            for there, clear, leads in self._blocking[kind, observer].meeting(place):
                using = users[there]
                if using is not None:
                    lead = leads[slot & 1] * seconds if is_drive else 0.0
                    for robot, step in using:
                        part = (self._drive(robot, step, clear, lead) if step % 2 else
                                self._wait(robot, step // 2, lead))
                        parts += [(robot, step, begin, end) for begin, end in part]
        return self._joined(sorted(parts))

    def _drive(self, robot: int, step: int, clears: Tuple[float, float],
               lead: float) -> Times:
        booked = self._robots[robot]
        drive, start, end, begun = booked.plan[step // 2]
        clear = clears[drive & 1]
        if begun:
            if clear <= begun:
                return ()
            clear = (clear - begun) / (1.0 - begun)
        begin = -inf if step // 2 < booked.held else start - lead
        return ((begin, start + clear * (end - start)),)

    def _wait(self, robot: int, number: int, lead: float) -> Times:
        wait = self._robots[robot].wait(number)
        return () if wait is None else ((wait[0] - lead, wait[1]),)

    def _joined(self, parts: Iterable[_Part]) -> List[Booking]:
        """Joins bookings. Returns one for each period in which one robot blocks without a break."""
        row: List[Booking] = []
        for robot, step, begin, end in parts:
            name = self._names[robot]
            if name not in self._left:
                continue
            is_planned = step % 2 and step // 2 >= self._robots[robot].held
            if is_planned and row and row[-1][2] == name and begin <= row[-1][1]:
                row[-1] = min(row[-1][0], begin), end, name
            elif is_planned or not extend(row, begin, end, name):
                row.append((begin, end, name))
        return row


def _places(booked: Booked, network: RoadNetwork) -> Iterator[int]:
    """Yields the robot's vertex, then the edge and the end of each drive; -1: between vertices."""
    yield booked.vertex if booked.mid_edge is None else -1
    for drive in booked.plan:
        yield network.vertices + (drive.drive >> 1)
        yield network.origin[drive.drive ^ 1]
