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
from sys import float_info
from time import monotonic as time_now
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from fleet_core.planning.agents import PathQuery
from fleet_core.planning.plans import Plan
from fleet_core.planning.safe_intervals import CHECKED, Arrival, plan_from
from fleet_core.planning.slots import Busy, Slots

_ROUNDING = 1e-9  # of a layer
_NO_VERTEX = -2   # the target behind the last leg

Search = Callable[..., Optional[Tuple[float, Plan]]]


def layered(seconds: float) -> Search:
    """Returns `find_path` with layers `seconds` apart. See `safe_intervals` for the arguments."""
    def search(query: PathQuery, slots: Slots, latest: float = inf,
               arrivals: Sequence[Arrival] = (),
               deadline: float = inf) -> Optional[Tuple[float, Plan]]:
        return _find_path(query, slots, seconds, latest, arrivals, deadline)
    return search


def _find_path(query: PathQuery, slots: Slots, layer: float, latest: float,
               arrivals: Sequence[Arrival], deadline: float) -> Optional[Tuple[float, Plan]]:
    legs, targets = len(query.destinations), (*query.destinations, _NO_VERTEX)
    to_go, later = _estimates(query)
    best: Dict[Tuple[int, int, int], float] = {}
    nodes: List[Tuple] = []
    heap: List[Tuple[float, int, int]] = []
    latest = min(latest, float_info.max)  # an infinite cost means that there is no path
    arrivals = arrivals or [(-1, 0.0, query.vertex, query.ready)]
    node, leg, served = -1, 0, query.ready
    steps = 0
    while True:
        steps += 1
        if steps % CHECKED == 0 and time_now() > deadline:
            return None
        for drive, begin, end, arrival in arrivals:
            until = _free_until(slots.busy(slots.drives + end), arrival)
            new_leg, new_served, leaves = leg, served, arrival
            if targets[leg] == end:
                new_leg, new_served, leaves = _serve(query, leg, served, arrival, until)
            k = ceil(leaves / layer - _ROUNDING)
            time = max(k * layer, leaves)
            if time > until:
                continue
            if new_leg < legs:
                cost = time + to_go[new_leg][end]
            else:
                cost = new_served + later * (time - new_served + to_go[new_leg][end])
            # After the horizon nothing changes, so that of all later layers only the first counts.
            key = (end, k if time <= slots.horizon else -1, new_leg)
            if cost <= latest and cost < best.get(key, inf):
                best[key] = cost
                heappush(heap, (cost, -k, len(nodes)))
                nodes.append((end, time, new_leg, new_served, until, k,
                              node, drive, begin, arrival))
        if not heap:
            return None
        cost, _, node = heappop(heap)
        vertex, now, leg, served, until, k = nodes[node][:6]
        if leg == legs and _may_rest(query, vertex, until):
            return cost, plan_from(nodes, node)
        arrivals = _moves(query, slots, vertex, now, (k + 1) * layer, until)


def _estimates(query: PathQuery) -> Tuple[Sequence[Sequence[float]], float]:
    """The seconds to go for each leg and behind the last one, and the weight of a second there."""
    if query.rests is None:  # the search ends at the last destination
        return (*query.to_go, [0.0] * len(query.roads)), 0.0
    return query.to_go, query.later


def _may_rest(query: PathQuery, vertex: int, until: float) -> bool:
    """May the robot end at this vertex, which is free `until` then?"""
    return query.rests is None or (until == inf and vertex in query.rests)


def _serve(query: PathQuery, leg: int, served: float, arrival: float,
           until: float) -> Tuple[int, float, float]:
    """Serves the destination of a leg, and each later one at the same vertex, while it is free.

    Returns the next leg, the time of the last service, and when the robot may leave.
    """
    targets, leaves = query.destinations, arrival
    here, last = targets[leg], len(targets) - 1
    while leg <= last and targets[leg] == here:
        done = leaves + query.dwells[leg]
        if done > until or (query.rests is None and leg == last and until < inf):
            break
        leaves = served = done
        leg += 1
    return leg, served, leaves


def _moves(query: PathQuery, slots: Slots, vertex: int, now: float, next_layer: float,
           until: float) -> List[Arrival]:
    """The drives that the robot may begin now, and waiting until the next layer."""
    busy = slots.busy
    moves = [(drive, now, end, now + seconds) for drive, end, seconds in query.roads[vertex]
             if _free_until(busy(drive), now) >= now]
    # after the horizon nothing changes any more
    if next_layer <= until and now <= slots.horizon:
        moves.append((-1, now, vertex, next_layer))
    return moves


def _free_until(busy: Busy, time: float) -> float:
    """How long a slot stays free from `time` on; -inf: it is not free at `time`."""
    at = bisect_right(busy[1], time)
    if at == len(busy[1]):
        return inf
    return busy[0][at] if busy[0][at] >= time else -inf
