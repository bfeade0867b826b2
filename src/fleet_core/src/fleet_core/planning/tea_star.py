"""TEA*: robots are planned one after the other. A plan is an obstacle in time for later robots.

The path planner of the dissertation uses the same loop. First the fixed drives of all robots are
booked. Then each robot looks for its path through time, past all paths found before. A robot that
finds no path comes first in a new order. Robots that are not in its way keep their paths, and only
the others look again. If this does not help, all robots are planned again. While a robot has no
plan yet, its place is an obstacle only for a moment, as in the first two layers of TEA*.
"""
from __future__ import annotations

import time
from math import inf
from random import Random
from typing import Dict, Iterable, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

from fleet_core.planning.agents import Agent
from fleet_core.planning.layers import Search
from fleet_core.planning.plans import Arrival, Plan
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.slots import Booking

PRESENT = 2.0
"""Time for which a robot without a plan is an obstacle, in multiples of its shortest drive."""


_TO_ANSWER = 5e-6  # s to book a drive of a plan and to put it into the answer


class Path(NamedTuple):
    """The path that was found for one robot: its cost, and the plan after the fixed drives."""

    cost: float
    plan: Plan


Paths = Dict[str, Path]


class TeaStar:
    """Plans agents one after the other, and books their paths in a reservation table."""

    def __init__(self, reservations: ReservationTable, search: Search = find_path) -> None:
        self.reservations = reservations
        self.unfinished: Paths = {}
        """The paths that the last call of `plan` found before its time was over; not booked."""
        self._search = search

    def path_of(self, agent: Agent, deadline: float, latest: float = inf) -> Optional[Path]:
        """Returns the best path of a robot without bookings, past all robots that are booked.

        None: there is no path, or the deadline (monotonic s) came first.
        """
        arrivals: Sequence[Arrival] = (agent.query.start,)
        if agent.mid_edge:
            arrivals = self.reservations.arrivals(agent.kind, agent.mid_edge,
                                                  agent.query.ready)
            if not arrivals:
                return None
        found = self._search(agent.query, self.reservations.slots[agent.kind], arrivals,
                             latest, deadline)
        if found is None:
            return None
        cost, plan = found
        if agent.mid_edge and plan:
            plan[0] = plan[0]._replace(begun=agent.mid_edge.behind(plan[0].drive))
        return Path(cost, plan)

    def book(self, agent: Agent, path: Path, until: float = inf) -> None:
        """Books a path as an obstacle for others. At its end the robot stands until `until`."""
        self.reservations.book(agent.name, agent.kind, agent.vertex,
                               agent.whole(path.plan), agent.mid_edge, until,
                               len(agent.fixed))

    def book_later(self, paths: Iterable[Tuple[Agent, Path]]) -> None:
        """Books many paths, but makes the bookings of a slot when a search first reads the slot."""
        self.reservations.book_later({
            agent.name: self.reservations.state(
                agent.kind, agent.vertex, agent.whole(path.plan), agent.mid_edge,
                held=len(agent.fixed)) for agent, path in paths})

    def book_fixed(self, agent: Agent) -> None:
        """Books only the fixed drives of a robot without a plan."""
        self.reservations.book(agent.name, agent.kind, agent.vertex, agent.fixed,
                               agent.mid_edge, agent.query.ready, len(agent.fixed))

    def book_present(self, agent: Agent) -> None:
        """Books the fixed drives of a robot without a plan, and its place for a moment."""
        self.reservations.book(agent.name, agent.kind, agent.vertex, agent.fixed,
                               agent.mid_edge, self._moment(agent), len(agent.fixed))

    def plan(self, agents: Sequence[Agent], deadline: float,
             orders: int) -> Optional[Paths]:
        """Returns paths for all agents; None: no order succeeded in time.

        At most `orders` orders are tried, the given one first. The agents must not be booked.
        """
        order = list(agents)
        paths: Paths = {}
        self.unfinished = {}
        put_first: Set[str] = set()
        for _ in range(orders):
            if not put_first:
                paths.clear()
                self.forget(order)
                for agent in order:
                    self.book_present(agent)
            failed = self._plan_in(order, paths, deadline)
            if failed is None:
                return paths
            if is_too_late(deadline, sum(len(path.plan) for path in paths.values())):
                self.unfinished = paths
                break
            order.remove(failed)
            order.insert(0, failed)
            if failed.name in put_first:  # put first already, but lost its path again
                put_first.clear()
            elif self._put_first(order, paths, deadline):
                put_first.add(failed.name)
            else:
                break
        self.forget(order)
        return None

    def forget(self, agents: Iterable[Agent]) -> None:
        """Removes the bookings of agents from the reservation table."""
        for agent in agents:
            self.reservations.cancel(agent.name)

    def _plan_in(self, order: Sequence[Agent], paths: Paths,
                 deadline: float) -> Optional[Agent]:
        """Plans the agents without a path in this order.

        Returns the first agent that finds no path in time.
        """
        drives = sum(len(path.plan) for path in paths.values())
        for agent in order:
            if agent.name not in paths:
                self.reservations.cancel(agent.name)
                path = self.path_of(agent, deadline)
                drives += len(path.plan) if path is not None else 0
                if path is None or is_too_late(deadline, drives):
                    return agent
                paths[agent.name] = path
                self.book(agent, path)
        return None

    def _put_first(self, order: Sequence[Agent], paths: Paths, deadline: float) -> bool:
        """Plans the first agent before the others. Agents that are in its way lose their paths.

        Returns False if the first agent finds no path even then.
        """
        first, planned = order[0], [t for t in order if t.name in paths]
        taken = self.reservations.take_out([t.name for t in planned])
        for agent in planned:
            self.book_present(agent)
        path = self.path_of(first, deadline)
        self.reservations.put_back(taken)
        if path is None:
            return False
        paths[first.name] = path
        self.book(first, path)
        booked = {kind: self.reservations.bookings_of(first.name, kind)
                  for kind in self.reservations.kinds}
        for agent in planned:
            if self._meets(agent, paths[agent.name], booked[agent.kind]):
                del paths[agent.name]
                self.reservations.cancel(agent.name)
                self.book_present(agent)
        return True

    def _meets(self, agent: Agent, path: Path,
               booked: Mapping[int, Sequence[Booking]]) -> bool:
        """Returns whether a path conflicts with the bookings of another robot (by slot)."""
        if agent.mid_edge:
            return True  # it stands between vertices, so it is simply planned again
        network = self.reservations.network
        vertex, since = agent.query.vertex, agent.query.ready
        for drive in path.plan:
            if (_overlap(booked.get(network.vertex_slot(vertex)), since, drive.start)
                    or _overlap(booked.get(drive.drive), drive.start, drive.start)):
                return True
            vertex, since = network.destination(drive.drive), drive.end
        return _overlap(booked.get(network.vertex_slot(vertex)), since, inf)

    def _moment(self, agent: Agent) -> float:
        network = self.reservations.network
        roads = (agent.mid_edge.exits(network, agent.kind) if agent.mid_edge
                 else agent.query.roads[agent.query.vertex])
        leaving = min((seconds for _, _, seconds in roads), default=0.0)
        return agent.query.ready + PRESENT * leaving


def _overlap(bookings: Optional[Sequence[Booking]], begin: float, end: float) -> bool:
    """Returns whether any booking overlaps the time from `begin` to `end`."""
    return bookings is not None and any(since < end and begin < until
                                        for since, until, _ in bookings)


def is_too_late(deadline: float, drives: int = 0) -> bool:
    """Returns whether the time up to the deadline (monotonic s) is too short to book and return
    this many drives.
    """
    return time.monotonic() + _TO_ANSWER * drives > deadline


def by_length(agents: Iterable[Agent]) -> List[Agent]:
    """Returns the agents in the first order: by priority, then by length of the shortest path.

    Robots with short paths are soon out of the way. So it costs less if a robot with a long path
    waits than if robots with short paths wait. A robot with nothing to do comes last, because it
    is only in the way.
    """
    return sorted(agents, key=lambda t: (-t.priority, not t.query.destinations,
                                         t.query.lower_bound))


def shuffled(agents: Iterable[Agent], random: Random) -> List[Agent]:
    """Returns a random order that still respects priorities."""
    order = list(agents)
    random.shuffle(order)
    return sorted(order, key=lambda t: -t.priority)
