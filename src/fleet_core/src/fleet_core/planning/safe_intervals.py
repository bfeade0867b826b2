"""The path of one robot through a reservation table: A* over safe intervals.

This is the search of TEA* with intervals in place of layers. A state is a vertex and one of the
intervals in which a robot may wait there. Of all paths into a state only the earliest counts,
because a robot that is early can wait (safe interval path planning, Phillips and Likhachev, ICRA
2011). Three things are added: beginnings of drives are booked (see `blocking`), one search covers
several destinations, and the robot rests for ever at the end. The successors of a state are made
only when they may be the best (partial expansion, Yoshizumi et al., AAAI 2000).
"""
from __future__ import annotations

from bisect import bisect_right
from heapq import heappop, heappush, heappushpop
from math import inf
from sys import float_info
from time import monotonic as time_now
from typing import Dict, List, Optional, Sequence, Tuple

from fleet_core.planning.agents import PathQuery
from fleet_core.planning.plans import Drive, Plan
from fleet_core.planning.slots import Slots

CHECKED = 256  # number of steps of a search between two looks at the clock

Arrival = Tuple[int, float, int, float]
"""A drive, when it begins, the vertex at its end, and when it arrives there."""


def find_path(errand: PathQuery, slots: Slots, latest: float = inf,
              arrivals: Sequence[Arrival] = (),
              deadline: float = inf) -> Optional[Tuple[float, Plan]]:
    """The plan that serves the errand soonest, and its cost. None: there is none in time.

    The cost is the time at the end of the last destination. The time after it has the errand's
    weight. No plan costs more than `latest`. The search ends at the deadline (monotonic s).

    arrivals -- the first drives of a robot between vertices, which does not start from a vertex
    """
    roads, to_go, targets, dwells = errand.roads, errand.to_go, errand.destinations, errand.dwells
    legs, vertices, drives = len(targets), len(roads), slots.drives
    rests, later = errand.rests or frozenset(), errand.later
    stays = errand.rests is None  # at the last destination
    merged, busy_of = slots.merged, slots.busy
    best: Dict[int, float] = {}
    nodes: List[Tuple] = []
    heap: List[Tuple[float, int, float]] = []
    latest = min(latest, float_info.max)  # an infinite cost means that there is no path
    node, leg, served = -1, 0, errand.ready
    moves = list(arrivals) or [(-1, 0.0, errand.vertex, errand.ready)]
    steps = 0
    while True:
        steps += 1
        if steps % CHECKED == 0 and time_now() > deadline:
            return None
        # the newest entry; it is often the next one to expand, and then never on the heap
        entry = None
        for drive, begin, end, arrival in moves:
            starts, ends = merged[drives + end] or busy_of(drives + end)
            interval, until = 0, inf
            if ends:
                interval = bisect_right(ends, arrival)
                if interval < len(ends):
                    until = starts[interval]
                    if until < arrival:
                        continue
            time, new_leg, new_served = arrival, leg, served
            while new_leg < legs and targets[new_leg] == end:
                leaves = time + dwells[new_leg]
                if leaves > until or (stays and new_leg == legs - 1 and until < inf):
                    break
                time = new_served = leaves
                new_leg += 1
            key = (interval * (legs + 1) + new_leg) * vertices + end
            if key in best and time >= best[key]:
                continue
            if new_leg < legs:
                cost = time + to_go[new_leg][end]
            elif stays:
                cost = new_served
            else:
                cost = new_served + later * (time - new_served + to_go[new_leg][end])
            if cost <= latest:
                best[key] = time
                if entry:
                    heappush(heap, entry)
                entry = cost, len(nodes), -inf
                nodes.append((end, time, new_leg, new_served, until, key,
                              node, drive, begin, arrival))
        while heap or entry:
            cost, node, done = heappushpop(heap, entry) if entry else heappop(heap)
            entry = None
            vertex, now, leg, served, until, key, _, _, _, _ = nodes[node]
            if best[key] == now:
                break
        else:
            return None
        if leg == legs and (stays or (until == inf and vertex in rests)):
            return cost, plan_from(nodes, node)
        estimates, base, weight = to_go[leg], now, 1.0
        if leg == legs:
            base, weight = served + later * (now - served), later
        moves, postponed = [], inf
        for drive, end, seconds in roads[vertex]:
            bound = base + weight * (seconds + estimates[end])
            if bound > cost:
                if bound < postponed:
                    postponed = bound
            elif bound > done:
                starts, ends = merged[drive] or busy_of(drive)
                if not ends or now >= ends[-1]:
                    moves.append((drive, now, end, now + seconds))
                else:
                    for begin in _beginnings(starts, ends, now, until):
                        moves.append((drive, begin, end, begin + seconds))
        if postponed <= latest:
            heappush(heap, (postponed, node, cost))


def _beginnings(starts: Sequence[float], ends: Sequence[float], now: float,
                until: float) -> List[float]:
    """The first moment of each free time of a slot between `now` and `until`.

    The slot is busy from each of `starts` to the one of `ends`.
    """
    gap, count = bisect_right(ends, now), len(ends)
    begins = [now] if now <= starts[gap] else []
    while ends[gap] <= until:
        begins.append(ends[gap])
        gap += 1
        if gap == count:
            break
    return begins


def plan_from(nodes: Sequence[Tuple], node: int) -> Plan:
    """The drives on the path to a node. A node ends with parent, drive, begin and arrival."""
    plan: Plan = []
    while True:
        parent, drive, begin, arrival = nodes[node][-4:]
        if drive >= 0:
            plan.append(Drive(drive, begin, arrival))
        if parent < 0:
            return plan[::-1]
        node = parent
