"""The path of one robot through a reservation table: A* over time layers, as in TEA*.

The layers k = 0, 1, 2 ... lie `seconds` apart. A robot waits from one layer to the next, or begins
a drive in a layer and goes on from the first layer after its arrival. Waiting is a step like
driving. So this search examines many more states than a search over safe intervals, and robots
begin drives only at layers. Both searches use the same reservation table.
"""
from __future__ import annotations

from bisect import bisect_right
from heapq import heappop, heappush
from itertools import count
from math import ceil, inf
from sys import float_info
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from fleet_core.planning.agents import PathQuery
from fleet_core.planning.plans import Arrival, Plan
from fleet_core.planning.safe_intervals import NO_VERTEX, State, plan_from, steps_until
from fleet_core.planning.slots import Busy, Slots

_ROUNDING = 1e-9  # of a layer

Search = Callable[..., Optional[Tuple[float, Plan]]]


def layered(seconds: float) -> Search:
    """Returns a search with layers `seconds` apart. Its arguments are those of
    `safe_intervals.find_path`.
    """
    def search(query: PathQuery, slots: Slots, arrivals: Sequence[Arrival], latest: float = inf,
               deadline: float = inf) -> Optional[Tuple[float, Plan]]:
        return _find_path(query, slots, seconds, arrivals, latest, deadline)
    return search


def _find_path(query: PathQuery, slots: Slots, layer: float, arrivals: Sequence[Arrival],
               latest: float, deadline: float) -> Optional[Tuple[float, Plan]]:
    legs, targets = query.legs, (*query.destinations, NO_VERTEX)
    to_go, later = query.to_go, query.later
    best: Dict[int, float] = {}
    heap: List[Tuple[float, int, int, State]] = []
    numbers = count()
    latest = min(latest, float_info.max)  # an infinite cost means that there is no path
    state: Optional[State] = None
    leg, served = 0, query.ready
    for _ in steps_until(deadline):
        for arrival in arrivals:
            _, _, end, arrives = arrival
            until = _free_until(slots.busy(slots.drives + end), arrives)
            new_leg, new_served, leaves = leg, served, arrives
            if targets[leg] == end:
                new_leg, new_served, leaves = query.serve(leg, served, arrives, until)
            k = ceil(leaves / layer - _ROUNDING)
            time = max(k * layer, leaves)
            if time > until:
                continue
            cost = time + to_go[new_leg][end] if new_leg < legs else (
                new_served + later * (time - new_served + to_go[new_leg][end]))
            # After the horizon nothing changes: all later layers count as the same layer.
            counted = k if time <= slots.horizon else -1
            key = (counted * (legs + 1) + new_leg) * len(query.roads) + end
            if cost <= latest and cost < best.get(key, inf):
                best[key] = cost
                heappush(heap, (cost, -k, next(numbers), (
                    end, time, new_leg, new_served, until, key, state, arrival)))
        if not heap:
            break
        cost, k, _, state = heappop(heap)
        vertex, _, leg, served, until, _, _, _ = state
        if leg == legs and query.may_rest(vertex, until):
            return cost, plan_from(state)
        arrivals = _moves(query, slots, state, (1 - k) * layer)
    return None


def _moves(query: PathQuery, slots: Slots, state: State, next_layer: float) -> List[Arrival]:
    """Returns the drives that the robot may begin now, and the wait until the next layer."""
    busy = slots.busy
    vertex, now, _, _, until, _, _, _ = state
    moves = [(drive, now, end, now + seconds) for drive, end, seconds in query.roads[vertex]
             if _free_until(busy(drive), now) >= now]
    # after the horizon nothing changes any more
    if next_layer <= until and now <= slots.horizon:
        moves.append((-1, now, vertex, next_layer))
    return moves


def _free_until(busy: Busy, time: float) -> float:
    """Returns the time until which a slot stays free from `time` on.

    If the returned time is before `time`, the slot is not free at `time`.
    """
    starts, ends = busy
    return starts[bisect_right(ends, time)]
