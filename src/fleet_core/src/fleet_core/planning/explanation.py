"""Explains in words which robots block other robots."""
from __future__ import annotations

import time
from functools import partial
from heapq import heappop, heappush
from math import inf
from operator import itemgetter
from typing import (
    Dict,
    FrozenSet,
    Iterable,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
)

import numpy as np

from fleet_core.fleet import RobotType
from fleet_core.planning.agents import Agent
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from trajectory_graph.drawn_names import at_vertex, drawn_ids, edge_name, vertex_name
from trajectory_graph.id_lists import listed

# s: the cost of a robot that stands in the way; so high that nearly every detour costs less
_BESIDE_ONE = 1e6


def out_of_reach(network: RoadNetwork, agent: Agent) -> str:
    """Returns why an agent has no path even without traffic. The reason names a vertex that is out
    of reach.
    """
    seconds_to, origin = agent.query.seconds_to, _where(network, agent)
    starts: Sequence[int] = ((agent.query.vertex,) if agent.mid_edge is None else
                             [end for _, end, _ in agent.mid_edge.exits(network, agent.kind)])
    for destination in agent.query.destinations:
        path = network.paths_to(agent.kind, (destination,))[0]
        if seconds_to(path) == inf:
            return (f'vertex {network.vertex_ids[destination]} cannot be reached from '
                    f'{origin}{why_apart(network, agent.kind, starts, destination)}')
        origin = f'vertex {network.vertex_ids[destination]}'
        starts = (destination,)
        seconds_to = partial(_entry, destination)
    return 'it has nowhere to stay; give the graph more parking'


def why_apart(network: RoadNetwork, kind: RobotType, starts: Iterable[int],
              destination: int) -> str:
    """Returns why robots of a type cannot drive from `starts` to `destination`.

    The result is a clause that follows `cannot be reached`.
    """
    starts, times, closed = tuple(starts), network.times(kind), network.closed_to(kind)

    def docks_on_path(with_closed: bool) -> Optional[List[int]]:
        """Returns the docks on a path that may lead through docks; None: there is no such path."""
        came: Dict[int, int] = dict.fromkeys(starts, -1)
        waiting = list(starts)
        for vertex in waiting:
            for signed_id in network.graph.edges_from(network.vertex_ids[vertex]):
                drive = network.drive(signed_id)
                end = network.destination(drive)
                is_open = with_closed or abs(signed_id) not in closed
                if end not in came and times[drive] < inf and is_open:
                    came[end] = vertex
                    waiting.append(end)
        if destination not in came:
            return None
        passed, vertex = [], came[destination]
        while vertex >= 0 and came[vertex] >= 0:
            passed += [network.vertex_ids[vertex]] if vertex in network.docks else []
            vertex = came[vertex]
        return passed

    docks = docks_on_path(with_closed=False)
    if docks:
        return (f': each way leads through a dock, such as dock {docks[-1]}, and no route leads '
                'through a dock')
    if closed and docks_on_path(with_closed=True) is not None:
        to_load = f' to robots of type {kind.name}' if kind.closed else ''
        return (f' while edges {listed(sorted(drawn_ids(network.graph, closed)))} are closed'
                f'{to_load}')
    return '; no edges lead there that it may drive'


def _entry(vertex: int, path: np.ndarray) -> float:
    return float(path[vertex])


def _where(network: RoadNetwork, agent: Agent) -> str:
    if agent.mid_edge is not None:
        return edge_name(network.graph, abs(network.signed_id(agent.mid_edge.drive)))
    return vertex_name(network.graph, network.vertex_ids[agent.query.vertex])


def in_the_way(reservations: ReservationTable, agent: Agent, deadline: float) -> List[str]:
    """Returns the robots that would have to give way to a robot that is not booked.

    These are

    - the robots that stand for ever on its path (the path with the fewest such robots), and
    - the robots whose plans lead over its own place.

    The search for the path ends at the deadline (monotonic s).
    """
    slots = reservations.slots[agent.kind]
    drives, found = _fewest_blocked(reservations, agent, deadline)
    for drive in drives:
        for _, end, robot in slots.row(drive):
            if end == inf:
                found[robot] = None
    if agent.mid_edge is None:
        for _, _, robot in slots.row(slots.drives + agent.query.vertex):
            found[robot] = None
    else:
        for robot, _ in reservations.passing(agent.kind, agent.mid_edge):
            found[robot] = None
    return list(found)


def why_not(reservations: ReservationTable, agent: Agent, deadline: float) -> str:
    """Returns why a robot that is not booked finds no path past the others.

    The search for the reason ends at the deadline (monotonic s).
    """
    network = reservations.network
    others = in_the_way(reservations, agent, deadline) if time.monotonic() < deadline else []
    destinations = agent.query.destinations
    goal = (f'vertex {network.vertex_ids[destinations[-1]]}' if destinations else 'parking')
    if not others:
        return f'no path to {goal} was found in the given time'
    where = []
    for name in others:
        booked = reservations.booked.get(name)
        if booked is None:
            where.append(f'{name}, which cannot move')
        elif booked.plan:
            end = network.vertex_ids[network.destination(booked.plan[-1].drive)]
            where.append(f'{name}, which will end {at_vertex(network.graph, end)}')
        elif booked.mid_edge is None:
            where.append(f'{name}, which stands '
                         f'{at_vertex(network.graph, network.vertex_ids[booked.vertex])}')
        else:
            edge = abs(network.signed_id(booked.mid_edge.drive))
            where.append(f'{name}, which stands on {edge_name(network.graph, edge)}')
    return f'on the way to {goal} it is blocked by {"; ".join(where)}'


def _fewest_blocked(reservations: ReservationTable,
                    agent: Agent, deadline: float) -> Tuple[List[int], Dict[str, None]]:
    """Returns the drives of a path over all destinations to a rest. This path leads past as few
    standing robots as possible.

    The path ends early if it cannot be continued. If the agent stands between two vertices, the
    path begins at the next vertex. The second value names the robots that stand between the agent
    and that vertex.
    """
    query = agent.query
    drives: List[int] = []
    goals: List[FrozenSet[int]] = [frozenset((d,)) for d in query.destinations]
    if query.rests is not None and query.rests.whole:
        goals.append(query.rests.whole)
    starts: Dict[int, float] = {query.vertex: 0.0}
    standing: Dict[int, Dict[str, None]] = {}
    if agent.mid_edge is not None:
        starts, standing = _exits(reservations, agent, agent.mid_edge)
    first = min(starts.items(), key=itemgetter(1), default=(-1, inf))[0]
    for number, goal in enumerate(goals):
        leg = (_shortest(reservations, agent, starts, goal) if time.monotonic() < deadline
               else None)
        if leg is None:
            break
        drives += leg.drives
        first = first if number else leg.start
        starts = {leg.end: 0.0}
    return drives, dict(standing.get(first, {}))


def _exits(reservations: ReservationTable, agent: Agent, mid_edge: MidEdgePosition
           ) -> Tuple[Dict[int, float], Dict[int, Dict[str, None]]]:
    """Returns the vertices to which a robot between two vertices may drive, with their costs.

    The second value has, for each vertex, the robots that stand for ever on the way to it.
    """
    costs: Dict[int, float] = {}
    standing: Dict[int, Dict[str, None]] = {}
    for drive, end, seconds in mid_edge.exits(reservations.network, agent.kind):
        robots = {robot: None for _, over, robot in reservations.against_rest(
            agent.kind, mid_edge, drive) if over == inf}
        cost = seconds + _BESIDE_ONE * len(robots)
        if cost < costs.get(end, inf):
            costs[end], standing[end] = cost, robots
    return costs, standing


class _Leg(NamedTuple):
    """A path from one of several vertices to one of several goals."""

    start: int
    drives: List[int]
    end: int


def _shortest(reservations: ReservationTable, agent: Agent, starts: Mapping[int, float],
              goal: FrozenSet[int]) -> Optional[_Leg]:
    bookings = reservations.slots[agent.kind].row
    came: Dict[int, Tuple[int, int]] = {}
    best: Dict[int, float] = dict(starts)
    heap: List[Tuple[float, int]] = sorted((cost, vertex) for vertex, cost in starts.items())
    while heap:
        cost, end = heappop(heap)
        if cost > best[end]:
            continue
        if end in goal:
            drives, vertex = [], end
            while vertex in came:
                vertex, drive = came[vertex]
                drives.append(drive)
            return _Leg(vertex, drives[::-1], end)
        for drive, further, seconds in agent.query.roads[end]:
            standing = {robot for _, over, robot in bookings(drive) if over == inf}
            new = cost + seconds + _BESIDE_ONE * len(standing)
            if new < best.get(further, inf):
                best[further] = new
                came[further] = end, drive
                heappush(heap, (new, further))
    return None
