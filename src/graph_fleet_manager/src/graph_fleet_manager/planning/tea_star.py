"""TEA*: robots planned one after the other, each plan an obstacle in time for those that follow.

The loop is that of the dissertation's path planner: what robots will drive in any case is booked
first; then every robot looks for its way through time, past all who have theirs; where one finds
none, it comes first in a new order. Who is not in its way there keeps what he has, and only the
others look again; if that does not help, all is planned again. While a robot has no plan yet, its
place is an obstacle only for a moment, as in the two first layers of TEA*.
"""
from __future__ import annotations

import time
from math import inf
from random import Random
from typing import Dict, Iterable, List, Mapping, NamedTuple, Optional, Sequence, Set

from graph_fleet_manager.planning.layers import Search
from graph_fleet_manager.planning.plans import Plan
from graph_fleet_manager.planning.safe_intervals import Arrival, find_way
from graph_fleet_manager.planning.slots import Booking
from graph_fleet_manager.planning.timetable import Timetable
from graph_fleet_manager.planning.travellers import Traveller

PRESENT = 2.0
"""For so many times its shortest way out a robot without a plan is in everybody's way."""


class Way(NamedTuple):
    """What a search found for one robot: its cost, and the plan behind what is fixed."""

    cost: float
    plan: Plan


Ways = Dict[str, Way]


class TeaStar:
    """Plans travellers against a timetable, in which their ways are booked when it is done."""

    def __init__(self, timetable: Timetable, search: Search = find_way) -> None:
        self.timetable = timetable
        self._search = search

    def way_of(self, traveller: Traveller, latest: float = inf) -> Optional[Way]:
        """The best way of one robot that is not booked, past all that are; None: there is none."""
        arrivals: Sequence[Arrival] = ()
        if traveller.between:
            arrivals = self.timetable.arrivals(traveller.kind, traveller.between,
                                               traveller.errand.ready)
            if not arrivals:
                return None
        found = self._search(traveller.errand, self.timetable.slots[traveller.kind], latest,
                             arrivals)
        if found is None:
            return None
        cost, plan = found
        if traveller.between and plan:
            plan[0] = plan[0]._replace(begun=traveller.between.behind(plan[0].drive))
        return Way(cost, plan)

    def book(self, traveller: Traveller, way: Way, until: float = inf) -> None:
        """Makes a way an obstacle for all others, and its end until some time."""
        self.timetable.book(traveller.name, traveller.kind, traveller.vertex,
                            traveller.whole(way.plan), traveller.between, until,
                            len(traveller.fixed))

    def book_fixed(self, traveller: Traveller) -> None:
        """Books only what a robot without a plan holds in any case."""
        self.timetable.book(traveller.name, traveller.kind, traveller.vertex, traveller.fixed,
                            traveller.between, traveller.errand.ready, len(traveller.fixed))

    def book_present(self, traveller: Traveller) -> None:
        """Books what a robot without a plan holds in any case, and for a moment where it is."""
        self.timetable.book(traveller.name, traveller.kind, traveller.vertex, traveller.fixed,
                            traveller.between, self._moment(traveller), len(traveller.fixed))

    def plan(self, travellers: Sequence[Traveller], deadline: float,
             orders: int) -> Optional[Ways]:
        """Ways for all, in at most `orders` orders; None where no order succeeded in time.

        The order given is tried first. Nobody of the travellers may be booked.
        """
        order = list(travellers)
        ways: Ways = {}
        put_first: Set[str] = set()
        for _ in range(orders):
            if not put_first:
                ways.clear()
                self.forget(order)
                for traveller in order:
                    self.book_present(traveller)
            failed = self._plan_in(order, ways, deadline)
            if failed is None:
                return ways
            if time.monotonic() > deadline:
                break
            order.remove(failed)
            order.insert(0, failed)
            if failed.name in put_first:  # and lost its way again: all are planned anew
                put_first.clear()
            elif self._put_first(order, ways):
                put_first.add(failed.name)
            else:
                break
        self.forget(order)
        return None

    def forget(self, travellers: Iterable[Traveller]) -> None:
        """Takes travellers out of the timetable."""
        for traveller in travellers:
            self.timetable.cancel(traveller.name)

    def _plan_in(self, order: Sequence[Traveller], ways: Ways,
                 deadline: float) -> Optional[Traveller]:
        """Plans those without a way in this order; returns who found none, or came too late."""
        for traveller in order:
            if traveller.name not in ways:
                self.timetable.cancel(traveller.name)
                way = self.way_of(traveller)
                if way is None or time.monotonic() > deadline:
                    return traveller
                ways[traveller.name] = way
                self.book(traveller, way)
        return None

    def _put_first(self, order: Sequence[Traveller], ways: Ways) -> bool:
        """Plans the first of the order as if it came first; who is in its way loses his own.

        False where it has no way even then.
        """
        first, planned = order[0], [t for t in order if t.name in ways]
        taken = self.timetable.take_out([t.name for t in planned])
        for traveller in planned:
            self.book_present(traveller)
        way = self.way_of(first)
        self.timetable.put_back(taken)
        if way is None:
            return False
        ways[first.name] = way
        self.book(first, way)
        booked = {kind: self.timetable.bookings_of(first.name, kind)
                  for kind in self.timetable.kinds}
        for traveller in planned:
            if self._meets(traveller, ways[traveller.name], booked[traveller.kind]):
                del ways[traveller.name]
                self.timetable.cancel(traveller.name)
                self.book_present(traveller)
        return True

    def _meets(self, traveller: Traveller, way: Way,
               booked: Mapping[int, Sequence[Booking]]) -> bool:
        """Does a way run into what is booked, by slot, for another robot?"""
        if traveller.between:
            return True  # where it stands is no vertex: it is simply planned again
        network = self.timetable.network
        vertex, since = traveller.errand.vertex, traveller.errand.ready
        for drive in way.plan:
            if (_overlap(booked.get(network.vertex_slot(vertex)), since, drive.start)
                    or _overlap(booked.get(drive.drive), drive.start, drive.start)):
                return True
            vertex, since = network.destination(drive.drive), drive.end
        return _overlap(booked.get(network.vertex_slot(vertex)), since, inf)

    def _moment(self, traveller: Traveller) -> float:
        roads = traveller.errand.roads[traveller.errand.vertex]
        way_out = min((seconds for _, _, seconds in roads), default=0.0)
        return traveller.errand.ready + PRESENT * way_out


def _overlap(bookings: Optional[Sequence[Booking]], begin: float, end: float) -> bool:
    """Is anything booked at any time between two, or at one within?"""
    return bookings is not None and any(since < end and begin < until
                                        for since, until, _ in bookings)


def by_length(travellers: Iterable[Traveller]) -> List[Traveller]:
    """The order to begin with: by priority, then who has the shortest way.

    A robot that waits for others that are soon out of its way waits less than these would for it;
    who has nothing to do comes last, for it is only in the way.
    """
    return sorted(travellers, key=lambda t: (-t.priority, not t.errand.destinations,
                                             t.errand.lower_bound))


def shuffled(travellers: Iterable[Traveller], random: Random) -> List[Traveller]:
    """A random order, within which priorities still count."""
    order = list(travellers)
    random.shuffle(order)
    return sorted(order, key=lambda t: -t.priority)
