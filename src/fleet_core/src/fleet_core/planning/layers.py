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

from fleet_core.planning.agents import PathQuery
from fleet_core.planning.plans import Plan
from fleet_core.planning.safe_intervals import CHECKED, Arrival, plan_from
from fleet_core.planning.slots import Busy, Slots

_ROUNDING = 1e-9  # of a layer

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
    rests, legs = query.rests, len(query.destinations)
    states = _States(query, slots, layer, latest)
    arrivals = arrivals or [(-1, 0.0, query.vertex, query.ready)]
    node, leg, served = -1, 0, query.ready
    steps = 0
    while True:
        steps += 1
        if steps % CHECKED == 0 and time_now() > deadline:
            return None
        states.add(arrivals, node, leg, served)
        if not states.heap:
            return None
        cost, _, node = heappop(states.heap)
        vertex, now, leg, served, until, k = states.nodes[node][:6]
        if leg == legs and (rests is None or (until == inf and vertex in rests)):
            return cost, plan_from(states.nodes, node)
        arrivals = _moves(query, slots, vertex, now, (k + 1) * layer, until)


class _States:
    """The states that a search has reached, and those from which it has not gone on yet.

    nodes -- vertex, time, leg, last service, until when the vertex is free, layer, and the arrival
    heap  -- cost, minus the layer, and number of the node
    """

    def __init__(self, query: PathQuery, slots: Slots, layer: float, latest: float) -> None:
        self.nodes: List[Tuple] = []
        self.heap: List[Tuple[float, int, int]] = []
        self._query, self._slots, self._layer, self._latest = query, slots, layer, latest
        self._best: Dict[Tuple[int, int, int], float] = {}

    def add(self, arrivals: Sequence[Arrival], node: int, leg: int, served: float) -> None:
        """Adds the states in which arrivals from a node end, if they may be the best."""
        query, slots, layer, best = self._query, self._slots, self._layer, self._best
        targets, to_go, stays = query.destinations, query.to_go, query.rests is None
        legs = len(targets)
        for drive, begin, end, arrival in arrivals:
            until = _free_until(slots.busy(slots.drives + end), arrival)
            new_leg, new_served, leaves = leg, served, arrival
            if leg < legs and targets[leg] == end:
                new_leg, new_served, leaves = _serve(query, leg, served, arrival, until)
            k = ceil(leaves / layer - _ROUNDING)
            time = max(k * layer, leaves)
            if time > until:
                continue
            if new_leg < legs:
                cost = time + to_go[new_leg][end]
            elif stays:
                cost = new_served
            else:
                cost = new_served + query.later * (time - new_served + to_go[new_leg][end])
            # After the horizon nothing changes, so that of all later layers only the first counts.
            key = (end, k if time <= slots.horizon else -1, new_leg)
            if cost <= self._latest and cost < inf and cost < best.get(key, inf):
                best[key] = cost
                heappush(self.heap, (cost, -k, len(self.nodes)))
                self.nodes.append((end, time, new_leg, new_served, until, k,
                                   node, drive, begin, arrival))


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
    moves = [(drive, now, end, now + seconds) for drive, end, seconds in query.roads[vertex]
             if _free_until(slots.busy(drive), now) >= now]
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
