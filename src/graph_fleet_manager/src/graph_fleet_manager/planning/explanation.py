"""Which robots block which, in words."""
from __future__ import annotations

from heapq import heappop, heappush
from math import inf
from typing import Dict, FrozenSet, List, Optional, Sequence, Tuple

from graph_fleet_manager.planning.agents import Agent
from graph_fleet_manager.planning.reservation_table import ReservationTable
from graph_fleet_manager.planning.road_network import RoadNetwork

_BESIDE_ONE = 1e6  # s that a robot would rather drive than past one more that stands in its way


def out_of_reach(network: RoadNetwork, agent: Agent) -> str:
    """Why a robot cannot serve its errand even alone: what it cannot reach, and from where."""
    at = agent.errand.vertex
    for destination in agent.errand.destinations:
        if at >= 0 and network.paths_to(agent.kind, (destination,))[0][at] == inf:
            closed = ', '.join(map(str, sorted(network.closed)))
            because = (f' while edges {closed} are closed' if closed else
                       '; no edges lead there that it may drive')
            return (f'vertex {network.vertex_ids[destination]} cannot be reached from vertex '
                    f'{network.vertex_ids[at]}{because}')
        at = destination
    return 'it has nowhere to stay; give the graph more parking'


def in_the_way(reservations: ReservationTable, agent: Agent) -> List[str]:
    """Robots that would have to give way: those that stand for ever where its path leads with the
    fewest of them, and those whose plans lead over the place where it is. It must not be booked.
    """
    slots = reservations.slots[agent.kind]
    found: Dict[str, None] = {}
    for drive in _fewest_blocked(reservations, agent):
        for _, end, robot in slots.bookings[drive]:
            if end == inf:
                found[robot] = None
    if agent.errand.vertex >= 0:
        for _, _, robot in slots.bookings[slots.drives + agent.errand.vertex]:
            found[robot] = None
    return list(found)


def why_not(reservations: ReservationTable, agent: Agent) -> str:
    """Why a robot that is not booked finds no path past the others."""
    network = reservations.network
    others = in_the_way(reservations, agent)
    destinations = agent.errand.destinations
    goal = (f'vertex {network.vertex_ids[destinations[-1]]}' if destinations else 'parking')
    if not others:
        return f'no way to {goal} was found in the time given'
    where = []
    for name in others:
        booked = reservations.booked.get(name)
        if booked is None:
            where.append(f'{name}, which cannot move')
        elif booked.plan:
            where.append(f'{name}, which comes to vertex '
                         f'{network.vertex_ids[network.destination(booked.plan[-1].drive)]}')
        elif booked.mid_edge is None:
            where.append(f'{name}, which stands at vertex {network.vertex_ids[booked.vertex]}')
        else:
            where.append(f'{name}, which stands on edge '
                         f'{abs(network.signed_id(booked.mid_edge.drive))}')
    return f'on the way to {goal} it is blocked by {"; ".join(where)}'


def _fewest_blocked(reservations: ReservationTable, agent: Agent) -> List[int]:
    """The drives of the path over all destinations to a rest, past as few standing robots as
    possible; as far as there is one."""
    errand = agent.errand
    at = errand.vertex
    drives: List[int] = []
    goals: List[FrozenSet[int]] = [frozenset((d,)) for d in errand.destinations]
    if errand.rests:
        goals.append(errand.rests)
    for goal in goals:
        leg = _shortest(reservations, agent, at, goal) if at >= 0 else None
        if leg is None:
            break
        drives += leg
        if leg:
            at = reservations.network.destination(leg[-1])
    return drives


def _shortest(reservations: ReservationTable, agent: Agent, start: int,
              goal: FrozenSet[int]) -> Optional[Sequence[int]]:
    bookings = reservations.slots[agent.kind].bookings
    came: Dict[int, Tuple[int, int]] = {}
    best: Dict[int, float] = {start: 0.0}
    heap: List[Tuple[float, int]] = [(0.0, start)]
    while heap:
        cost, vertex = heappop(heap)
        if cost > best[vertex]:
            continue
        if vertex in goal:
            drives = []
            while vertex != start:
                vertex, drive = came[vertex]
                drives.append(drive)
            return drives[::-1]
        for drive, end, seconds in agent.errand.roads[vertex]:
            standing = {robot for _, over, robot in bookings[drive] if over == inf}
            new = cost + seconds + _BESIDE_ONE * len(standing)
            if new < best.get(end, inf):
                best[end] = new
                came[end] = vertex, drive
                heappush(heap, (new, end))
    return None
