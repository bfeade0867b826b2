"""Switches the order of use while robots are late: reverses groups if that gains time.

A late robot holds up each robot that comes after it. The order of an edge group may be reversed
until a robot is granted a drive in the group. The plans still lead to the same places, and the
order must stay free of rings (switchable action dependency graphs: Berndt et al., T-RO 2024). The
paper solves a mixed-integer program. This module searches greedily, group by group. The cost of an
order follows from the longest paths through a graph. Its nodes are the beginnings of drives.

Safety does not depend on this module: a robot is granted only places that are free. But a ring
would be a deadlock.
"""
from __future__ import annotations

import time
from math import inf
from typing import Dict, FrozenSet, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

from fleet_core.planning.edge_groups import EdgeGroup
from fleet_core.planning.precedence import Constraint

GAIN = 5.0     # s that all robots together must gain from a change
LATE = 5.0     # s of delay after which a drive that waits for another robot counts as late
TRIALS = 40    # maximum number of orders that are tried
_IN_A_ROW = 6  # maximum number of groups that are reversed together
_LATER = 1e-4  # weight of a second after the errand; a second before its end weighs 1
_EPSILON = 1e-6  # s


class RemainingDrives(NamedTuple):
    """The remaining drives of a robot and their times, in s from now.

    first   -- number of the first of these drives in its plan
    begins  -- when the first drive begins without delay by others; below 0: it has begun
    seconds -- of each drive
    pauses  -- the minimum stay before each drive
    planned -- when each drive begins according to the plan in force
    done    -- number of the first drive after the robot's errand; None: it has no errand
    """

    first: int
    begins: float
    seconds: Tuple[float, ...]
    pauses: Tuple[float, ...]
    planned: Tuple[float, ...]
    done: Optional[int] = None


class Switched(NamedTuple):
    """An order of the drives that differs from the order of the plan.

    reversed -- numbers of the groups whose order is reversed
    starts   -- when each robot is to begin each of its remaining drives
    gain     -- s that all robots together gain
    """

    reversed: FrozenSet[int]
    starts: Dict[str, Tuple[float, ...]]
    gain: float

    def order(self, groups: Sequence[EdgeGroup]) -> Tuple[Constraint, ...]:
        """Returns the constraints of the new order."""
        return tuple(constraint for number, group in enumerate(groups)
                     for constraint in (group.reverse if number in self.reversed
                                        else group.constraints))


def switch_order(courses: Mapping[str, RemainingDrives], groups: Sequence[EdgeGroup],
                 gain: float = GAIN, trials: int = TRIALS,
                 deadline: float = inf) -> Optional[Switched]:
    """Returns a better order, or None if there is no better one.

    It searches only if a robot is so late that it holds up another robot.

    gain     -- s that each change must gain for all robots together
    deadline -- monotonic s
    """
    orders = _Orders(courses, groups, trials, deadline)
    begun = orders.evaluate(frozenset())
    if begun is None or not orders.is_late(begun):
        return None
    best = _Order(frozenset(), begun)
    nodes = orders.waiting(best)
    while nodes and not orders.is_over:
        better = orders.let_through(best, nodes.pop(0), gain)
        if better is not None:
            best = better
            nodes = orders.waiting(best)
    if not best.reversed:
        return None
    return Switched(best.reversed, orders.by_robot(best.times), begun.cost - best.times.cost)


class _Times(NamedTuple):
    """The times of an order: when each node begins, and the weighted sum of the ends."""

    starts: List[float]
    cost: float


class _Order(NamedTuple):
    """The reversed groups of an order, and its times."""

    reversed: FrozenSet[int]
    times: _Times


class _Arc(NamedTuple):
    """In one order of `group`, the node `then` begins no earlier than `lag` s after `node`."""

    node: int
    then: int
    lag: float
    group: int  # -1: the arc is in no group, because both drives belong to one robot
    is_reverse: bool


class _Orders:
    """All orders of the groups. The nodes are the beginnings of drives, sorted by robot.

    Nodes and arcs are kept in lists by number, because each trial walks through all of them.
    """

    def __init__(self, courses: Mapping[str, RemainingDrives], groups: Sequence[EdgeGroup],
                 trials: int, deadline: float) -> None:
        self._groups = groups
        self._left, self._deadline = trials, deadline
        self._nodes: Dict[str, range] = {}
        self._earliest: List[float] = []
        self._planned: List[float] = []
        # node, seconds of its drive, weight of its end
        self._ends: List[Tuple[int, float, float]] = []
        self._before: List[List[_Arc]] = []
        self._behind: List[List[Tuple[int, float, int, bool]]] = []
        self._of_group: List[List[_Arc]] = [[] for _ in groups]
        for name, course in courses.items():
            self._add_course(name, course)
        for number, group in enumerate(groups):
            for is_reverse, side in enumerate((group.constraints, group.reverse)):
                for constraint in side:
                    self._add_constraint(courses, constraint, number, bool(is_reverse))
        self._open = [sum(not arc.is_reverse for arc in arcs) for arcs in self._before]

    def _add_course(self, name: str, course: RemainingDrives) -> None:
        first, count = len(self._earliest), len(course.seconds)
        self._nodes[name] = range(first, first + count)
        self._earliest += [course.begins] * min(count, 1) + [-inf] * (count - 1)
        self._planned += course.planned
        self._before += [[] for _ in range(count)]
        self._behind += [[] for _ in range(count)]
        for k in range(1, count):
            self._add(_Arc(first + k - 1, first + k, course.seconds[k - 1] + course.pauses[k],
                           -1, False))
        if count:
            self._ends.append((first + count - 1, course.seconds[-1], _LATER))
        if course.done is not None and 0 < course.done - course.first <= count:
            k = course.done - course.first - 1
            self._ends.append((first + k, course.seconds[k], 1.0))

    def _add_constraint(self, courses: Mapping[str, RemainingDrives], constraint: Constraint,
                        group: int, is_reverse: bool) -> None:
        before, then = courses.get(constraint.first), courses.get(constraint.then)
        if before is None or then is None:
            return
        one, other = constraint.before - before.first, constraint.drive - then.first
        if one >= 0 and other >= 0:
            arc = _Arc(self._nodes[constraint.first][one], self._nodes[constraint.then][other],
                       constraint.fraction * before.seconds[one], group, is_reverse)
            self._add(arc)
            self._of_group[group].append(arc)

    def _add(self, arc: _Arc) -> None:
        self._before[arc.then].append(arc)
        self._behind[arc.node].append(arc[1:])

    @property
    def is_over(self) -> bool:
        """Whether the trials or the time are used up."""
        return self._left <= 0 or time.monotonic() >= self._deadline

    def by_robot(self, times: _Times) -> Dict[str, Tuple[float, ...]]:
        """Returns when each robot begins its drives."""
        return {name: tuple(times.starts[node] for node in nodes)
                for name, nodes in self._nodes.items()}

    # -- one order --------------------------------------------------------------------------------

    def evaluate(self, chosen: FrozenSet[int]) -> Optional[_Times]:
        """Returns the times of an order from the longest paths; None: the order has a ring."""
        times, open_nodes = self._passed(chosen)
        return None if open_nodes else times

    def _passed(self, chosen: FrozenSet[int]) -> Tuple[_Times, Set[int]]:
        """Returns the times with the `chosen` groups reversed, and the nodes that then wait for
        ever. The times of these nodes are not known.
        """
        self._left -= 1
        starts, waits = list(self._earliest), list(self._open)
        side = [False] * (len(self._groups) + 1)  # the last entry stands for no group
        for number in chosen:
            side[number] = True
            for arc in self._of_group[number]:
                waits[arc.then] += 1 if arc.is_reverse else -1
        ready = [node for node, count in enumerate(waits) if not count]
        passed = 0
        while ready:
            node = ready.pop()
            passed += 1
            start = starts[node]
            for then, lag, group, is_reverse in self._behind[node]:
                if side[group] is is_reverse:
                    if start + lag > starts[then]:
                        starts[then] = start + lag
                    waits[then] -= 1
                    if not waits[then]:
                        ready.append(then)
        cost = sum(weight * (starts[node] + seconds) for node, seconds, weight in self._ends)
        ring = set() if passed == len(starts) else {n for n, count in enumerate(waits) if count}
        return _Times(starts, cost), ring

    def is_late(self, times: _Times) -> bool:
        """Returns whether a robot is so late that another one begins a drive later than planned."""
        starts = times.starts
        return any(starts[then] > self._planned[then] + LATE and any(
            arc.group >= 0 and not arc.is_reverse
            and starts[arc.node] + arc.lag > self._planned[then] + LATE for arc in arcs)
            for then, arcs in enumerate(self._before))

    def waiting(self, order: _Order) -> List[int]:
        """Returns the nodes that wait for another robot longer than planned, the longest wait
        first.
        """
        found = []
        for node, arcs in enumerate(self._before):
            if order.times.starts[node] <= self._planned[node] + LATE:
                continue
            own = max([self._earliest[node], *(order.times.starts[arc.node] + arc.lag
                                               for arc in arcs if arc.group < 0)])
            wait = order.times.starts[node] - own
            if wait > _EPSILON:
                found.append((-wait, node))
        return [node for _, node in sorted(found)]

    # -- search for a better order ----------------------------------------------------------------

    def let_through(self, order: _Order, node: int, gain: float) -> Optional[_Order]:
        """Lets a waiting robot go ahead of the robots that it waits for, one robot after the other,
        until the gain is enough.
        """
        tried = order
        for _ in range(_IN_A_ROW):
            binding = {arc.group for arc in self._active(node, tried.reversed)
                       if tried.times.starts[arc.node] + arc.lag
                       >= tried.times.starts[node] - _EPSILON}
            if not binding or -1 in binding or not all(
                    self._groups[group].reverse for group in binding):
                return None
            another = self._without_rings(tried.reversed ^ binding, binding, self._robot(node))
            if another is None:
                return None
            tried = another
            if tried.times.cost < order.times.cost - gain:
                return tried
        return None

    def _without_rings(self, chosen: FrozenSet[int], turned: Set[int],
                       robot: range) -> Optional[_Order]:
        """Reverses further groups until there is no ring. It prefers groups in which `robot` waits.
        """
        turned = set(turned)
        for _ in range(_IN_A_ROW):
            if self.is_over:
                return None
            times, ring = self._passed(chosen)
            if not ring:
                return _Order(chosen, times)
            loose = [arc for arc in self._ring(ring, chosen)
                     if arc.group >= 0 and arc.group not in turned
                     and self._groups[arc.group].reverse]
            if not loose:
                return None
            group = min(loose, key=lambda arc: arc.then not in robot).group
            turned.add(group)
            chosen ^= {group}
        return None

    def _ring(self, nodes: Set[int], chosen: FrozenSet[int]) -> List[_Arc]:
        """Returns one ring among `nodes`; each of these nodes waits for another."""
        node = min(nodes)
        path: List[_Arc] = []
        seen: Dict[int, int] = {}
        while node not in seen:
            seen[node] = len(path)
            path.append(next(arc for arc in self._active(node, chosen) if arc.node in nodes))
            node = path[-1].node
        return path[seen[node]:]

    def _active(self, node: int, chosen: FrozenSet[int]) -> List[_Arc]:
        return [arc for arc in self._before[node]
                if (arc.group in chosen) is arc.is_reverse]

    def _robot(self, node: int) -> range:
        return next(nodes for nodes in self._nodes.values() if node in nodes)
