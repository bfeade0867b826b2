"""Who goes before whom: the action dependency graph of a plan, safe whatever runs late.

For every pair of drives that exclude each other the plan's times fix an order. Kept, that order
makes the plan safe however long a drive takes and wherever a robot comes to rest; the times only
matter for its cost (Hoenig et al., RA-L 2019). The order is written as constraints: robot b may
begin its drive j only once robot a has driven the fraction f of its drive i.
"""
from __future__ import annotations

from collections import deque
from types import MappingProxyType
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.planning.plans import Drive, Plans
from graph_fleet_manager.planning.timetable import Timetable

_ROUNDING = 1e-9  # s


class Constraint(NamedTuple):
    """`then` may begin drive `drive` only once `first` has driven `fraction` of `before`."""

    first: str
    before: int
    fraction: float  # of the drive's arc length, 0..1
    then: str
    drive: int


class Conflicting(Exception):
    """A plan in which two robots hold at once what they may not: a defect of the planner."""


def precedence(timetable: Timetable, plans: Plans, kinds: Mapping[str, RobotType],
               released: Mapping[str, int] = MappingProxyType({})) -> List[Constraint]:
    """The constraints that keep `plans` safe, none of which follows from another of the same pair.

    So many first drives of each robot as `released` says need none any more: all that had to come
    before them has come. Raises Conflicting where the times of the plans themselves are not safe.
    """
    users: Dict[RobotType, List[Optional[Dict[str, Tuple[int, float, float]]]]] = {
        kind: [None] * timetable.network.drives for kind in timetable.kinds}
    drives = timetable.network.drives
    constraints: List[Constraint] = []
    known: Dict[Tuple[str, str], Tuple[int, float]] = {}
    order = sorted((k >= released.get(name, 0), drive.start, drive.end, name, k)
                   for name, plan in plans.items() for k, drive in enumerate(plan))
    for planned, start, end, name, k in order:
        drive, kind = plans[name][k], kinds[name]
        before = users[kind][drive.drive]
        if before and planned and drive.begun:
            before = _users_of_rest(timetable, plans, kinds, name, drive)
        if before and planned:
            for other, (i, fraction, until) in before.items():
                if other == name:
                    continue
                if until > start + _ROUNDING:
                    raise Conflicting(f'{name} would begin edge '
                                      f'{timetable.network.signed_id(drive.drive)} at {start} s, '
                                      f'but {other} is not out of its way before {until} s')
                if known.get((name, other), (-1, 0.0)) < (i, fraction):
                    known[name, other] = (i, fraction)
                    constraints.append(Constraint(other, i, fraction, name, k))
        begun, seconds = drive.begun, end - start
        for observer, rows in users.items():
            for slot, clear, _ in timetable.blocking[kind, observer].drive(drive.drive):
                if slot < drives and clear > begun:
                    using = rows[slot]
                    if using is None:
                        using = rows[slot] = {}
                    share = (clear - begun) / (1.0 - begun) if begun else clear
                    using[name] = (k, clear, start + share * seconds)
    return constraints


def _users_of_rest(timetable: Timetable, plans: Plans, kinds: Mapping[str, RobotType], name: str,
                   rest: Drive) -> Dict[str, Tuple[int, float, float]]:
    """Who uses, before a robot that stands between two vertices, what the rest of its edge needs.

    For each the last such drive, the fraction at which it is out of the way, and the time of that.
    What only concerns the part that lies behind the robot is left out, as in the timetable.
    """
    found: Dict[str, Tuple[int, float, float]] = {}
    kind = kinds[name]
    behind = rest.begun * timetable.network.times(kind)[rest.drive]
    for other, plan in plans.items():
        for k, (drive, start, end, begun) in enumerate(plan):
            if other == name or start > rest.start:
                continue
            for slot, clear, lead in timetable.blocking[kinds[other], kind].drive(drive):
                if slot == rest.drive and clear > begun and lead > behind:
                    share = (clear - begun) / (1.0 - begun)
                    found[other] = (k, clear, start + share * (end - start))
    return found


def has_cycle(lengths: Mapping[str, int], constraints: Sequence[Constraint]) -> bool:
    """Would robots wait for each other in a ring? `lengths`: how many drives each plan has."""
    waits: Dict[Tuple[str, int], int] = {}
    frees: Dict[Tuple[str, int], List[Tuple[str, int]]] = {}

    def add(before: Tuple[str, int], after: Tuple[str, int]) -> None:
        frees.setdefault(before, []).append(after)
        waits[after] = waits.get(after, 0) + 1

    for name, count in lengths.items():
        for k in range(count):
            waits.setdefault((name, k), 0)
            if k:
                add((name, k - 1), (name, k))
    for constraint in constraints:
        add((constraint.first, constraint.before), (constraint.then, constraint.drive))
    ready = deque(drive for drive, count in waits.items() if count == 0)
    done = 0
    while ready:
        done += 1
        for after in frees.get(ready.popleft(), ()):
            waits[after] -= 1
            if waits[after] == 0:
                ready.append(after)
    return done < len(waits)
