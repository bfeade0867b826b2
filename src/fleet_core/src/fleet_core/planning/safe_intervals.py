"""The path of one robot through a reservation table: A* over safe intervals.

This is the search of TEA* with intervals in place of layers. A state is a vertex and one of the
intervals in which a robot may wait there. Only the path that reaches a state earliest counts,
because a robot that is early can wait (safe interval path planning, Phillips and Likhachev, ICRA
2011). Three things are added: beginnings of drives are booked (see `blocking`), one search covers
several destinations, and the robot rests for ever at the end. The search makes the successors of a
state only when one of them may be the best (partial expansion, Yoshizumi et al., AAAI 2000).
"""
from __future__ import annotations

from bisect import bisect_right
from heapq import heappop, heappush, heappushpop
from itertools import chain, count, repeat
from math import inf
from sys import float_info
from time import monotonic as time_now
from typing import Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

from fleet_core.planning.agents import PathQuery
from fleet_core.planning.plans import Arrival, Drive, Plan
from fleet_core.planning.slots import Slots

_CHECKED = 256  # number of steps of a search between two looks at the clock
NO_VERTEX = -2
"""The target when all destinations are served."""

State = Tuple[int, float, int, float, float, int, Optional['State'], Arrival]
"""A robot on a vertex, where it may wait, and how it came there.

vertex, time -- where the robot is, and when it may drive on
leg          -- index of its next destination
served       -- the end of its stay at the last destination that it served
until        -- the end of the time for which it may wait
key          -- number for vertex, leg and interval; among states with one key, the earliest counts
parent       -- the state before this one; None: there is none
arrival      -- the drive from the parent to this state

It is a plain tuple, because a search makes very many states, and to make a named tuple takes
several times as long. The code that reads a state names its fields.
"""
_Entry = Tuple[float, int, float, State]
"""A state whose successors are not all made yet.

Its fields are: the lowest cost of those paths through the state that are not followed yet; a number
that grows with each state; the cost up to which paths are followed already; the state.
"""


def find_path(query: PathQuery, slots: Slots, arrivals: Sequence[Arrival], latest: float = inf,
              deadline: float = inf) -> Optional[Tuple[float, Plan]]:
    """Returns the cheapest plan that answers the query, with its cost; None: none was found.

    The cost is the time when the last destination is served, plus the time after that with the
    weight `query.later`. No plan costs more than `latest`. The search ends at the deadline
    (monotonic s).

    arrivals -- the query's start, or the first drives of a robot between vertices
    """
    to_go, later, vertices = query.to_go, query.later, len(query.roads)
    legs, targets = query.legs, (*query.destinations, NO_VERTEX)
    merged, busy_of, drives = slots.merged, slots.busy, slots.drives
    best: Dict[int, float] = {}
    numbers = count()
    heap: List[_Entry] = []
    latest = min(latest, float_info.max)  # an infinite cost means that there is no path
    state: Optional[State] = None
    leg, served = 0, query.ready
    for _ in steps_until(deadline):
        newest = None
        for arrival in arrivals:
            _, _, end, time = arrival
            starts, ends = merged[drives + end] or busy_of(drives + end)
            interval = bisect_right(ends, time)
            until = starts[interval]
            if until < time:
                continue
            new_leg, new_served = leg, served
            if end == targets[leg]:
                new_leg, new_served, time = query.serve(leg, served, time, until)
            key = (interval * (legs + 1) + new_leg) * vertices + end
            if key in best and time >= best[key]:
                continue
            if new_leg < legs:
                cost = time + to_go[new_leg][end]
            else:
                cost = new_served + later * (time - new_served + to_go[new_leg][end])
            if cost <= latest:
                best[key] = time
                if newest:
                    heappush(heap, newest)
                newest = cost, next(numbers), -inf, (
                    end, time, new_leg, new_served, until, key, state, arrival)
        found = _next(heap, newest, best)
        if found is None:
            break
        cost, number, made, state = found
        vertex, _, leg, served, until, _, _, _ = state
        if leg == legs and query.may_rest(vertex, until):
            return cost, plan_from(state)
        arrivals, postponed = _successors(query, slots, state, cost, made)
        if postponed <= latest:
            heappush(heap, (postponed, number, cost, state))
    return None


def steps_until(deadline: float) -> Iterator[None]:
    """Yields once for each step of a search. Ends when a look at the clock shows that the deadline
    has passed.
    """
    in_time = iter(lambda: time_now() <= deadline, False)
    return chain(repeat(None, _CHECKED),
                 chain.from_iterable(repeat(None, _CHECKED) for _ in in_time))


def _next(heap: List[_Entry], newest: Optional[_Entry],
          best: Mapping[int, float]) -> Optional[_Entry]:
    """Takes the entry with the lowest cost. Drops an entry if an earlier state has the same key.

    newest -- an entry that is not in the heap yet; often this entry is taken
    """
    while heap or newest:
        entry = heappushpop(heap, newest) if newest else heappop(heap)
        newest = None
        state = entry[3]
        if best[state[5]] == state[1]:
            return entry
    return None


def _successors(query: PathQuery, slots: Slots, state: State, cost: float,
                made: float) -> Tuple[List[Arrival], float]:
    """Returns the drives from a state on paths that cost more than `made`, and at most `cost`.

    The second value is the lowest cost of the paths that are left for later.
    """
    vertex, now, leg, served, until, _, _, _ = state
    estimates, base, weight = query.to_go[leg], now, 1.0
    if leg == query.legs:
        base, weight = served + query.later * (now - served), query.later
    moves, postponed = [], inf
    for drive, end, seconds in query.roads[vertex]:
        bound = base + weight * (seconds + estimates[end])
        if bound > cost:
            if bound < postponed:
                postponed = bound
        elif bound > made:
            starts, ends = slots.merged[drive] or slots.busy(drive)
            if not ends or now >= ends[-1]:
                moves.append((drive, now, end, now + seconds))
            else:
                for begin in _beginnings(starts, ends, now, until):
                    moves.append((drive, begin, end, begin + seconds))
    return moves, postponed


def _beginnings(starts: Sequence[float], ends: Sequence[float], now: float,
                until: float) -> List[float]:
    """Returns the beginning of each free time of a slot between `now` and `until`.

    The slot is blocked from `starts[k]` to `ends[k]`, for each k.
    """
    gap, blocks = bisect_right(ends, now), len(ends)
    begins = [now] if now <= starts[gap] else []
    while ends[gap] <= until:
        begins.append(ends[gap])
        gap += 1
        if gap == blocks:
            break
    return begins


def plan_from(state: Optional[State]) -> Plan:
    """Returns the drives on the path to a state."""
    plan: Plan = []
    while state:
        _, _, _, _, _, _, state, (drive, begin, _, end) = state
        if drive >= 0:
            plan.append(Drive(drive, begin, end))
    return plan[::-1]
