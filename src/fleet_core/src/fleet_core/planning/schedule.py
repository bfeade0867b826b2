"""Times for drives whose order is known: each drive begins as early as its predecessors allow.

A plan is safe by its order of use, not by its times. The drives come in an order that keeps every
precedence (by their times in an older plan, or by the steps of LaCAM). They get new times here in
one sweep.
"""
from __future__ import annotations

from math import inf
from typing import Dict, Iterable, List, Mapping, Tuple

from fleet_core.fleet import RobotType
from fleet_core.planning.agents import Agent
from fleet_core.planning.plans import Drive, Plan, Plans
from fleet_core.planning.reservation_table import ReservationTable


def schedule(reservations: ReservationTable, agents: Mapping[str, Agent],
             order: Iterable[Tuple[str, int]]) -> Plans:
    """The plans behind the fixed drives, for the drives (robot, drive) in `order`.

    A robot later in the order waits until all earlier ones are out of its way. Only geometry and
    driving times of `reservations` are used, not its bookings.
    """
    network = reservations.network
    count = network.drives + network.vertices
    free_from: Dict[RobotType, List[float]] = {kind: [-inf] * count for kind in reservations.kinds}
    plans: Plans = {}
    ready: Dict[str, float] = {}
    legs: Dict[str, int] = {}

    def use(kind: RobotType, drive: Drive) -> None:
        for observer, free in free_from.items():
            for slot, clear, _ in reservations.blocking[kind, observer].drive(drive.drive):
                if clear > drive.begun:
                    share = (clear - drive.begun) / (1.0 - drive.begun)
                    until = drive.start + share * (drive.end - drive.start)
                    if until > free[slot]:
                        free[slot] = until

    for name, agent in agents.items():
        plans[name] = []
        ready[name], legs[name] = agent.query.served_at(agent.query.vertex, 0,
                                                         agent.query.ready)
        for fixed in agent.fixed:
            use(agent.kind, fixed)
    for name, drive in order:
        agent, plan = agents[name], plans[name]
        begun = 0.0
        if agent.mid_edge and not plan:
            begun = agent.mid_edge.behind(drive)
        seconds = network.times(agent.kind)[drive] * (1.0 - begun)
        start = max(ready[name], free_from[agent.kind][drive])
        plan.append(Drive(drive, start, start + seconds, begun))
        use(agent.kind, plan[-1])
        ready[name], legs[name] = agent.query.served_at(
            network.destination(drive), legs[name], start + seconds)
    return plans


def in_order(plans: Mapping[str, Plan]) -> List[Tuple[str, int]]:
    """The drives of plans in the order of their times."""
    timed = [(drive.start, drive.end, name, k) for name, plan in plans.items()
             for k, drive in enumerate(plan)]
    return [(name, plans[name][k].drive) for _, _, name, k in sorted(timed)]
