"""The action dependency graph of a plan: the order of use of places, safe for all delays.

For each pair of drives that exclude each other, the plan's times fix an order. If that order is
kept, the plan is safe however long a drive takes and wherever a robot comes to rest. The times
affect only the cost (Hoenig et al., RA-L 2019). The order is written as constraints: robot b may
begin its drive j only after robot a has driven the fraction f of its drive i.

All drives form one sequence, which keeps the order of each robot's own drives. Each constraint
points forward in this sequence. So robots never wait for each other in a ring.
"""
from __future__ import annotations

from itertools import chain
from types import MappingProxyType
from typing import Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from fleet_core.fleet import RobotType
from fleet_core.geometry.arrays import count_up, order_of
from fleet_core.planning.plans import Plans
from fleet_core.planning.reservation_table import ReservationTable

_ROUNDING = 1e-9  # s


class Constraint(NamedTuple):
    """`then` may begin its drive `drive` only after `first` has driven `fraction` of `before`."""

    first: str
    before: int
    fraction: float  # of the drive's arc length, 0..1
    then: str
    drive: int


class Conflicting(Exception):
    """Two robots would be too near to each other in a plan, which is a defect of the planner."""


class _Drives(NamedTuple):
    """All N drives of all robots, in the order in which they begin, as columns."""

    robot: np.ndarray    # (N,) number in the order of the robots' names
    number: np.ndarray   # (N,) within the robot's plan
    drive: np.ndarray    # (N,)
    start: np.ndarray    # (N,) s
    end: np.ndarray      # (N,) s
    begun: np.ndarray    # (N,) 0..1
    planned: np.ndarray  # (N,) whether it is not released yet


class _Pairs(NamedTuple):
    """M pairs of drives of different robots: `first` must be clear before `then` begins."""

    first: np.ndarray     # (M,) index into _Drives
    fraction: np.ndarray  # (M,) of the first drive's arc length, after which it is out of the way
    then: np.ndarray      # (M,) index into _Drives


def precedence(reservations: ReservationTable, plans: Plans, kinds: Mapping[str, RobotType],
               released: Mapping[str, int] = MappingProxyType({})) -> List[Constraint]:
    """Returns the constraints that keep `plans` safe. Constraints that follow from others between
    the same two robots are omitted.

    `released` is the number of first drives of each robot that are released. They need no
    constraint, because all that had to come before them has happened. Raises Conflicting if the
    times of the plans are not safe, or if the drives of a robot are not in the order of their
    times.
    """
    names = sorted(name for name, plan in plans.items() if plan)
    if not names:
        return []
    drives = _in_order(plans, names, released)
    kind_of = np.array([reservations.kinds.index(kinds[name]) for name in names])[drives.robot]
    found = [meetings(reservations, drives, moving, observer, kind_of == m, kind_of == o)
             for m, moving in enumerate(reservations.kinds)
             for o, observer in enumerate(reservations.kinds)
             for meetings in (_meetings, _meetings_of_rests)]
    pairs = _Pairs(*map(np.concatenate, zip(*found)))
    _check(reservations, names, drives, pairs)
    pairs = _without_what_follows(drives, pairs)
    return [Constraint(names[a], i, fraction, names[b], j) for a, i, fraction, b, j in zip(
        drives.robot[pairs.first].tolist(), drives.number[pairs.first].tolist(),
        map(float, pairs.fraction), drives.robot[pairs.then].tolist(),
        drives.number[pairs.then].tolist())]


def _in_order(plans: Plans, names: Sequence[str], released: Mapping[str, int]) -> _Drives:
    """Returns all drives: the released ones first, then the others by time.

    Raises Conflicting if this changes the order of the drives of one robot.
    """
    counts = np.array([len(plans[name]) for name in names])
    robot, number = np.repeat(np.arange(len(names)), counts), count_up(counts)
    rows = chain.from_iterable(plans[name] for name in names)
    values = np.fromiter(chain.from_iterable(rows), dtype=float, count=4 * len(robot))
    drive, start, end, begun = values.reshape(-1, 4).T
    planned = number >= np.array([released.get(name, 0) for name in names])[robot]
    order = np.lexsort((number, robot, end, start, planned))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    back = np.flatnonzero((np.diff(place) < 0) & (np.diff(robot) == 0))
    if len(back):
        raise Conflicting(f'{names[robot[back[0]]]} would begin its drive {number[back[0]] + 1} '
                          'before the drive that leads there')
    columns = robot, number, drive.astype(np.int64), start, end, begun, planned
    return _Drives(*(column[order] for column in columns))


def _meetings(reservations: ReservationTable, drives: _Drives, moving: RobotType,
              observer: RobotType, moves: np.ndarray, observes: np.ndarray) -> _Pairs:
    """Returns pairs: each planned drive of an observer and, for each moving robot, its last earlier
    drive that conflicts with the planned drive.

    Only robots of the given types count.
    """
    conflicts = reservations.blocking[moving, observer].conflicts
    vertices, count = reservations.network.vertices, len(drives.drive)
    after = np.flatnonzero(observes & drives.planned & (drives.begun == 0.0))
    edge_after = drives.drive[after] >> 1
    wanted = np.zeros(len(conflicts.starts) - 1, dtype=bool)
    wanted[vertices + edge_after] = True
    before = np.flatnonzero(moves)
    place = vertices + (drives.drive[before] >> 1)
    lengths = conflicts.starts[place + 1] - conflicts.starts[place]
    at = np.repeat(conflicts.starts[place], lengths) + count_up(lengths)
    before = np.repeat(before, lengths)
    forward = drives.drive[before] % 2 == 0
    fraction = np.where(forward, conflicts.forward[at], conflicts.backward[at])
    counts = wanted[conflicts.other[at]] & (fraction > drives.begun[before])
    before, fraction = before[counts], fraction[counts]
    # The uses of each edge by each robot form one group; each group is in order.
    edge, robot = conflicts.other[at][counts] - vertices, drives.robot[before]
    robots = int(drives.robot.max()) + 1
    by_robot = edge * robots + robot
    use = order_of(by_robot)
    before, fraction, by_robot = before[use], fraction[use], by_robot[use]
    starts = np.flatnonzero(np.diff(by_robot, prepend=-1))
    groups = by_robot[starts]
    # For each drive, and each robot that ever uses the drive's edge: the last use before the drive.
    low = np.searchsorted(groups, edge_after * robots)
    lengths = np.searchsorted(groups, (edge_after + 1) * robots) - low
    group = np.repeat(low, lengths) + count_up(lengths)
    then = np.repeat(after, lengths)
    other = groups[group] % robots != drives.robot[then]
    group, then = group[other], then[other]
    number = np.repeat(np.arange(len(starts)), np.diff(np.append(starts, len(before))))
    last = np.searchsorted(number * count + before, group * count + then) - 1
    used = last >= starts[group]
    return _Pairs(before[last[used]], fraction[last[used]], then[used])


def _meetings_of_rests(reservations: ReservationTable, drives: _Drives, moving: RobotType,
                       observer: RobotType, moves: np.ndarray, observes: np.ndarray) -> _Pairs:
    """Returns the same as `_meetings`, for observers that stand between two vertices.

    As in the reservation table, conflicts that concern only the part of the edge behind the
    observer are ignored.
    """
    conflicts = reservations.blocking[moving, observer].conflicts
    clear = conflicts.forward, conflicts.backward
    place = reservations.network.vertices + (drives.drive >> 1)
    found = [_Pairs(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0, dtype=np.int64))]
    for then in map(int, np.flatnonzero(observes & drives.planned & (drives.begun > 0.0))):
        row = slice(conflicts.starts[place[then]], conflicts.starts[place[then] + 1])
        ahead = clear[drives.drive[then] % 2][row] > drives.begun[then]
        mirrored = dict(zip(conflicts.other[row][ahead].tolist(),
                            conflicts.transpose[row][ahead].tolist()))
        last: Dict[int, Tuple[int, float]] = {}
        for k in np.flatnonzero(moves[:then] & (drives.robot[:then] != drives.robot[then])):
            if place[k] in mirrored:
                fraction = clear[drives.drive[k] % 2][mirrored[place[k]]]
                if fraction > drives.begun[k]:
                    last[int(drives.robot[k])] = (int(k), float(fraction))
        if last:
            first, fractions = zip(*last.values())
            found.append(_Pairs(np.array(first), np.array(fractions), np.full(len(first), then)))
    return _Pairs(*map(np.concatenate, zip(*found)))


def _check(reservations: ReservationTable, names: Sequence[str], drives: _Drives,
           pairs: _Pairs) -> None:
    """Raises Conflicting if the order may have rings, or if the times of the plans do not fit the
    order.
    """
    if (pairs.first >= pairs.then).any():
        raise Conflicting('a drive would wait for a drive that comes later in the order of all')
    start, begun = drives.start[pairs.first], drives.begun[pairs.first]
    share = (pairs.fraction - begun) / (1.0 - begun)
    until = start + share * (drives.end[pairs.first] - start)
    wrong = np.flatnonzero(until > drives.start[pairs.then] + _ROUNDING)
    if len(wrong):
        k = wrong[0]
        first, then = pairs.first[k], pairs.then[k]
        raise Conflicting(
            f'{names[drives.robot[then]]} would begin edge '
            f'{reservations.network.signed_id(int(drives.drive[then]))} at {drives.start[then]} s, '
            f'but {names[drives.robot[first]]} is not out of its way before {until[k]} s')


def _without_what_follows(drives: _Drives, pairs: _Pairs) -> _Pairs:
    """Returns the pairs that add a condition; the others follow from earlier pairs."""
    first, fraction, then = pairs
    by_demand = np.lexsort((fraction, drives.number[first]))
    demand = np.zeros(len(first), dtype=np.int64)
    more = ((np.diff(drives.number[first][by_demand]) != 0)
            | (np.diff(fraction[by_demand]) != 0.0))
    demand[by_demand[1:]] = np.cumsum(more)
    two = drives.robot[then] * (drives.robot.max() + 1) + drives.robot[first]
    order = np.lexsort((then, two))
    group = np.cumsum(np.concatenate(([0], np.diff(two[order]) != 0)))[:len(order)]
    most = np.maximum.accumulate(demand[order] + group * (len(order) + 1))
    new = np.concatenate(([True], np.diff(most) > 0))[:len(order)]
    return _Pairs(*(column[np.sort(order[new])] for column in pairs))
