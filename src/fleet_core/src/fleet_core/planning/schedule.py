"""Times for drives whose order is known: each drive begins as early as its predecessors allow.

A plan is safe because of its order of use, not because of its times. The drives come in an order
that keeps every precedence: the order of an older plan, or of the steps of LaCAM. One pass gives
them new times.
"""
from __future__ import annotations

from math import inf
from typing import Iterable, List, Mapping, Tuple

from fleet_core.fleet import RobotType
from fleet_core.planning.agents import Agent
from fleet_core.planning.plans import Drive, Plan, Plans
from fleet_core.planning.reservation_table import ReservationTable


def schedule(reservations: ReservationTable, agents: Mapping[str, Agent],
             order: Iterable[Tuple[str, int]]) -> Plans:
    """Returns the plans after the fixed drives.

    `order` has the drives as (robot, drive). Each drive waits until all earlier drives are out of
    its way. The function uses only geometry and driving times of `reservations`, not the bookings.
    """
    network = reservations.network
    lines = {kind: _Line(reservations, kind) for kind in reservations.kinds}
    drivers = {name: _Driver(agent, lines) for name, agent in agents.items()}
    for name, drive in order:
        drivers[name].drive(drive, network.destination(drive))
    return {name: driver.plan for name, driver in drivers.items()}


class _Line:
    """When each edge is free for robots of one type, after the drives that were added so far."""

    def __init__(self, reservations: ReservationTable, kind: RobotType) -> None:
        self.times = reservations.network.times(kind)
        self.free_from = [-inf] * (reservations.network.drives // 2)
        self.blocking = [(other, reservations.blocking[kind, other])
                         for other in reservations.kinds]


class _Driver:
    """One robot: its plan so far, when it may go on, and the next of its destinations."""

    def __init__(self, agent: Agent, lines: Mapping[RobotType, _Line]) -> None:
        line = lines[agent.kind]
        self.plan: Plan = []
        self._query, self._mid_edge = agent.query, agent.mid_edge
        self._times, self._free_from = line.times, line.free_from
        self._blocked = [(lines[other].free_from, blocking.edges)
                         for other, blocking in line.blocking]
        self._ready, self._leg = agent.query.served_at(agent.query.vertex, 0, agent.query.ready)
        for fixed in agent.fixed:
            self._use(fixed)

    def drive(self, drive: int, destination: int) -> None:
        """Adds a drive to the plan. It begins as soon as both the robot and the edge are free."""
        begun = self._mid_edge.behind(drive) if self._mid_edge and not self.plan else 0.0
        start = max(self._ready, self._free_from[drive >> 1])
        end = start + self._times[drive] * (1.0 - begun)
        self.plan.append(Drive(drive, start, end, begun))
        self._use(self.plan[-1])
        self._ready, self._leg = self._query.served_at(destination, self._leg, end)

    def _use(self, drive: Drive) -> None:
        number, start, end, begun = drive
        seconds = end - start
        for free_from, edges in self._blocked:
            for edge, clear in edges(number):
                if clear > begun:
                    until = start + (clear - begun) / (1.0 - begun) * seconds
                    if until > free_from[edge]:
                        free_from[edge] = until


def in_order(plans: Mapping[str, Plan]) -> List[Tuple[str, int]]:
    """Returns the drives of plans in the order of their times."""
    timed = [(drive.start, drive.end, name, k) for name, plan in plans.items()
             for k, drive in enumerate(plan)]
    return [(name, plans[name][k].drive) for _, _, name, k in sorted(timed)]
