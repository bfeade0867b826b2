"""Keeps the robots' present plans that can still be driven, with new times."""
from __future__ import annotations

from math import inf
from typing import Dict, Iterable, List, Mapping, Sequence, Tuple

from fleet_core.planning.agents import Agent
from fleet_core.planning.plans import Plans
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.schedule import schedule
from fleet_core.planning.tasks import PlannedDrive, Task


def kept_plans(reservations: ReservationTable, tasks: Mapping[str, Task],
               agents: Mapping[str, Agent]) -> Plans:
    """The present plans that can be driven, with new times in the old order.

    Robots that stand for ever must be booked, and no others. This function books nothing.
    """
    kept: Dict[str, Sequence[PlannedDrive]] = {
        name: plan for name, agent in agents.items()
        for plan in (tasks[name].kept,)
        if plan is not None and _can_be_driven(reservations, agent, plan)}
    _drop_passing(kept, reservations, agents)
    order: List[Tuple[float, float, str, int]] = sorted(
        (drive.start, drive.end, name, k) for name, plan in kept.items()
        for k, drive in enumerate(plan))
    plans = schedule(reservations, agents, (
        (name, reservations.network.drive(kept[name][k].edge)) for _, _, name, k in order))
    return {name: plans[name] for name in kept}


def _drop_passing(kept: Dict[str, Sequence[PlannedDrive]], reservations: ReservationTable,
                  agents: Mapping[str, Agent]) -> None:
    """Drops the plans that lead past a robot without a plan."""
    strangers = [agent for name, agent in agents.items() if name not in kept]
    while strangers:
        passing = [name for name, plan in kept.items() if any(
            _passes(reservations, agents[name], plan, stranger) for stranger in strangers)]
        strangers = [agents[name] for name in passing]
        for name in passing:
            del kept[name]


def _can_be_driven(reservations: ReservationTable, agent: Agent,
                   kept: Sequence[PlannedDrive]) -> bool:
    """Does a plan lead on from its robot's place, over open edges, past all that is booked?"""
    network, vertex = reservations.network, agent.query.vertex
    slots, times = reservations.slots[agent.kind], network.times(agent.kind)
    for edge, _, _ in kept:
        if abs(edge) not in network.edge_index:
            return False
        drive = network.drive(edge)
        if vertex >= 0 or agent.mid_edge is None:
            begins = network.origin[drive] == vertex and abs(edge) not in network.closed
        else:  # the robot may leave even a closed edge
            begins = drive >> 1 == agent.mid_edge.drive >> 1
        if not begins or times[drive] == inf or slots.row(drive):
            return False
        vertex = network.destination(drive)
    return True


def _passes(reservations: ReservationTable, owner: Agent, kept: Sequence[PlannedDrive],
            stranger: Agent) -> bool:
    """Does the plan of one robot lead past the place where another one stands?"""
    blocking = reservations.blocking[stranger.kind, owner.kind]
    blocked: Iterable[Tuple[int, float]]
    if stranger.mid_edge is not None:
        blocked = reservations.at_point(stranger.kind, owner.kind, stranger.mid_edge)
    else:
        blocked = blocking.wait(stranger.query.vertex)
    slots = {slot for slot, _ in blocked}
    return any(reservations.network.drive(drive.edge) in slots for drive in kept)
