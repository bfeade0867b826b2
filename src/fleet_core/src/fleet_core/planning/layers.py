"""The path of one robot through a reservation table: A* over time layers, as in TEA*.

The layers k = 0, 1, 2 ... lie `seconds` apart. A robot waits from one layer to the next, or begins
a drive in a layer and goes on from the first layer after its arrival. Waiting is a step like
driving. So this search examines many more states than a search over safe intervals, and robots
start only in layers. It uses the same reservation table.
"""
from __future__ import annotations

from bisect import bisect_right
from heapq import heappop, heappush
from math import ceil, inf
from time import monotonic as time_now
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from fleet_core.planning.agents import Errand
from fleet_core.planning.plans import Plan
from fleet_core.planning.safe_intervals import CHECKED, Arrival, plan_from
from fleet_core.planning.slots import Busy, Slots

_ROUNDING = 1e-9  # of a layer

Search = Callable[..., Optional[Tuple[float, Plan]]]


def layered(seconds: float) -> Search:
    """Returns `find_path` with layers `seconds` apart. See `safe_intervals` for the arguments."""
    def search(errand: Errand, slots: Slots, latest: float = inf,
               arrivals: Sequence[Arrival] = (),
               deadline: float = inf) -> Optional[Tuple[float, Plan]]:
        return _find_path(errand, slots, seconds, latest, arrivals, deadline)
    return search


def _find_path(errand: Errand, slots: Slots, layer: float, latest: float,
               arrivals: Sequence[Arrival], deadline: float) -> Optional[Tuple[float, Plan]]:
    targets, dwells, rests = errand.destinations, errand.dwells, errand.rests
    legs = len(targets)
    best: Dict[Tuple[int, int, int], float] = {}
    nodes: List[Tuple] = []
    heap: List[Tuple[float, int, int]] = []
    arrivals = arrivals or [(-1, 0.0, errand.vertex, errand.ready)]
    node, leg, served = -1, 0, errand.ready
    steps = 0
    while True:
        steps += 1
        if steps % CHECKED == 0 and time_now() > deadline:
            return None
        for drive, begin, end, arrival in arrivals:
            until = _free_until(slots.busy(slots.drives + end), arrival)
            new_leg, new_served, leaves = leg, served, arrival
            while new_leg < legs and targets[new_leg] == end:
                done = leaves + dwells[new_leg]
                if done > until or (rests is None and new_leg == legs - 1 and until < inf):
                    break
                leaves = new_served = done
                new_leg += 1
            k = ceil(leaves / layer - _ROUNDING)
            time = max(k * layer, leaves)
            if time > until:
                continue
            if new_leg < legs:
                cost = time + errand.to_go[new_leg][end]
            elif rests is None:
                cost = new_served
            else:
                cost = new_served + errand.later * (
                    time - new_served + errand.to_go[new_leg][end])
            # After the horizon nothing changes, so that of all later layers only the first counts.
            key = (end, k if time <= slots.horizon else -1, new_leg)
            if cost <= latest and cost < inf and cost < best.get(key, inf):
                best[key] = cost
                heappush(heap, (cost, -k, len(nodes)))
                nodes.append((end, time, new_leg, new_served, until, k,
                              node, drive, begin, arrival))
        if not heap:
            return None
        cost, _, node = heappop(heap)
        vertex, now, leg, served, until, k = nodes[node][:6]
        if leg == legs and (rests is None or (until == inf and vertex in rests)):
            return cost, plan_from(nodes, node)
        arrivals = [(drive, now, end, now + seconds)
                    for drive, end, seconds in errand.roads[vertex]
                    if _free_until(slots.busy(drive), now) >= now]
        # after the horizon nothing changes any more
        if (k + 1) * layer <= until and now <= slots.horizon:
            arrivals.append((-1, now, vertex, (k + 1) * layer))


def _free_until(busy: Busy, time: float) -> float:
    """How long a slot stays free from `time` on; -inf: it is not free at `time`."""
    at = bisect_right(busy[1], time)
    if at == len(busy[1]):
        return inf
    return busy[0][at] if busy[0][at] >= time else -inf
