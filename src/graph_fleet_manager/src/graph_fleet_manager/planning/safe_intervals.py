"""The way of one robot through a timetable: A* over safe intervals.

The same search as TEA*'s layers with intervals in their place: a state is a vertex and one of the
intervals in which a robot may wait there, and of all ways into a state only the earliest counts,
for who is early can wait (safe interval path planning, Phillips and Likhachev, ICRA 2011). Added
here: bookings are of beginnings of drives (see `blocking`), several destinations in one search,
and a rest for ever at the end.
"""
from __future__ import annotations

from bisect import bisect_right
from heapq import heappop, heappush
from math import inf
from typing import Dict, List, Optional, Sequence, Tuple

from graph_fleet_manager.planning.plans import Drive, Plan
from graph_fleet_manager.planning.road_network import Roads
from graph_fleet_manager.planning.timetable import Slots

LATER = 1e-4
"""What a second on the way to parking weighs against one on the way to the destinations."""


class Errand:
    """What one robot has to do, with all that the search needs to know of the way.

    vertex       -- where it is free to go from, at time `ready`
    destinations -- vertices to visit in order
    dwells       -- s to stay at each
    rests        -- vertices at which it may end for ever; None: at the last destination
    to_go        -- for each leg, the seconds from every vertex over all destinations left to the
                    last; behind them one more where there are rests: to the nearest of these
    roads        -- where it may drive
    """

    def __init__(self, vertex: int, ready: float, destinations: Sequence[int],
                 dwells: Sequence[float], rests: Optional[frozenset], to_go: Sequence[List[float]],
                 roads: Roads) -> None:
        self.vertex = vertex
        self.ready = ready
        self.destinations = tuple(destinations)
        self.dwells = tuple(dwells)
        self.rests = rests
        self.to_go = to_go
        self.roads = roads


def find_way(errand: Errand, slots: Slots, drives: int, latest: float = inf) -> Optional[Plan]:
    """The plan that serves the errand soonest, None where there is none.

    Soonest counts the end of the last destination first; the way to parking after it next. `drives`
    is the number of drives, behind which the slots of vertices begin; no plan costs more than
    `latest`.
    """
    roads, to_go, targets, dwells = errand.roads, errand.to_go, errand.destinations, errand.dwells
    legs, vertices = len(targets), len(roads)
    rests = errand.rests
    stays = rests is None  # at the last destination
    merged, busy_of = slots.merged, slots.busy
    best: Dict[int, float] = {}
    nodes: List[Tuple] = []
    heap: List[Tuple[float, int]] = []
    # What a drive leads to: (drive, when it begins, where and when it ends)
    arrivals: List[Tuple[int, float, int, float]] = [(-1, 0.0, errand.vertex, errand.ready)]
    node, vertex, leg, served = -1, -1, 0, errand.ready
    while True:
        for drive, begin, end, time in arrivals:
            busy = merged[drives + end]
            if busy is None:
                busy = busy_of(drives + end)
            interval, until = 0, inf
            if busy[1]:
                interval = bisect_right(busy[1], time)
                if interval < len(busy[1]):
                    until = busy[0][interval]
                    if until < time:
                        continue
            new_leg, new_served, arrival = leg, served, time
            while new_leg < legs and targets[new_leg] == end:
                leaves = time + dwells[new_leg]
                if leaves > until or (stays and new_leg == legs - 1 and until < inf):
                    break
                time = new_served = leaves
                new_leg += 1
            key = (interval * (legs + 1) + new_leg) * vertices + end
            if time >= best.get(key, inf):
                continue
            if new_leg < legs:
                cost = time + to_go[new_leg][end]
            elif stays:
                cost = new_served
            else:
                cost = new_served + LATER * (time - new_served + to_go[new_leg][end])
            if cost <= latest and cost < inf:
                best[key] = time
                heappush(heap, (cost, len(nodes)))
                nodes.append((end, time, new_leg, new_served, until, key,
                              node, drive, begin, arrival))
        while heap:
            node = heappop(heap)[1]
            vertex, now, leg, served, until, key = nodes[node][:6]
            if best[key] == now:
                break
        else:
            return None
        if leg == legs and (stays or (until == inf and vertex in rests)):
            return _plan(nodes, node)
        arrivals = []
        for drive, end, seconds in roads[vertex]:
            busy = merged[drive]
            if busy is None:
                busy = busy_of(drive)
            starts, ends = busy
            if not ends:
                arrivals.append((drive, now, end, now + seconds))
                continue
            gap, begin, count = bisect_right(ends, now), now, len(ends)
            while begin <= until:
                if gap == count:
                    arrivals.append((drive, begin, end, begin + seconds))
                    break
                if begin <= starts[gap]:
                    arrivals.append((drive, begin, end, begin + seconds))
                begin = ends[gap]
                gap += 1


def _plan(nodes: Sequence[Tuple], node: int) -> Plan:
    plan: Plan = []
    while True:
        parent, drive, begin, arrival = nodes[node][6:]
        if parent < 0:
            break
        plan.append(Drive(drive, begin, arrival))
        node = parent
    plan.reverse()
    return plan
