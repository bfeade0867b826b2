"""Keeps the robots' present plans that can still be driven, with new times."""
from __future__ import annotations

from math import inf
from typing import Dict, Iterable, List, Mapping, Sequence, Set, Tuple

from fleet_core.fleet import RobotType
from fleet_core.planning.agents import Agent
from fleet_core.planning.plans import Plans
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.schedule import schedule
from fleet_core.planning.tasks import Task


def kept_plans(reservations: ReservationTable, tasks: Mapping[str, Task],
               agents: Mapping[str, Agent]) -> Plans:
    """Returns the present plans that can still be driven, in their old order, with new times.

    Before the call, the robots that stand for ever must be booked, and no others. This function
    books nothing.
    """
    network = reservations.network
    kept = {name: plan for name in agents for plan in (tasks[name].kept,) if plan is not None}
    drives = {name: [network.drive(drive.edge) for drive in plan] for name, plan in kept.items()
              if all(abs(drive.edge) in network.edge_index for drive in plan)}
    drives = {name: some for name, some in drives.items()
              if _can_be_driven(reservations, agents[name], some)}
    _drop_passing(drives, reservations, agents)
    order: List[Tuple[float, float, str, int]] = sorted(
        (drive.start, drive.end, name, k) for name in drives
        for k, drive in enumerate(kept[name]))
    plans = schedule(reservations, agents, ((name, drives[name][k]) for _, _, name, k in order))
    return {name: plans[name] for name in drives}


def _can_be_driven(reservations: ReservationTable, agent: Agent, drives: Sequence[int]) -> bool:
    """Returns whether a plan begins at its robot's place, uses only open edges, and meets no
    booking.
    """
    network, vertex = reservations.network, agent.query.vertex
    slots, times = reservations.slots[agent.kind], network.times(agent.kind)
    closed = network.closed_to(agent.kind)
    for drive in drives:
        if vertex >= 0 or agent.mid_edge is None:
            begins = network.origin[drive] == vertex and (
                abs(network.signed_ids[drive]) not in closed)
        else:  # the robot may leave even a closed edge
            begins = drive >> 1 == agent.mid_edge.drive >> 1
        if not begins or times[drive] == inf or slots.row(drive):
            return False
        vertex = network.destination(drive)
    return True


def _drop_passing(drives: Dict[str, List[int]], reservations: ReservationTable,
                  agents: Mapping[str, Agent]) -> None:
    """Drops the plans that lead past a robot without a plan."""
    strangers = [agent for name, agent in agents.items() if name not in drives]
    while strangers:
        passed = {kind: _passed(reservations, strangers, kind) for kind in reservations.kinds}
        passing = [name for name, some in drives.items()
                   if not passed[agents[name].kind].isdisjoint(some)]
        strangers = [agents[name] for name in passing]
        for name in passing:
            del drives[name]


def _passed(reservations: ReservationTable, strangers: Iterable[Agent],
            kind: RobotType) -> Set[int]:
    """Returns the drives on which a robot of a type would pass one of these robots."""
    passed: Set[int] = set()
    for stranger in strangers:
        blocked: Iterable[Tuple[int, float]]
        if stranger.mid_edge is not None:
            blocked = reservations.at_point(stranger.kind, kind, stranger.mid_edge)
        else:
            blocked = reservations.blocking[stranger.kind, kind].wait(stranger.query.vertex)
        passed.update(slot for slot, _ in blocked)
    return passed
