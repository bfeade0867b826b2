"""Edge groups: conflicts between two plans whose order can be reversed only as a whole.

Draw the drives of one robot along x and those of another robot along y. Mark each pair of drives
that exclude each other. The two plans are a path through this picture that passes each mark on one
side. Marks that touch each other, also at a corner, form a *group*. One order holds for all marks
of a group, whether the robots drive through it one behind the other or against each other. The path
may pass the group on its other side instead, with one exception: one of the robots was granted a
drive in the group, stands in it already, or ends in it. (Edge grouping: Feng et al., AAAI 2025.)
"""
from __future__ import annotations

from typing import Callable, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from fleet_core.fleet import RobotType
from fleet_core.geometry.arrays import count_up
from fleet_core.planning.plans import Drive
from fleet_core.planning.precedence import Constraint
from fleet_core.planning.road_network import RoadNetwork

_TOUCHING = (0, 1), (1, -1), (1, 0), (1, 1)  # steps from a mark to the later marks that touch it


class RobotProgress(NamedTuple):
    """The progress of a robot on its plan. Drives are counted from 0.

    released   -- number of its first drives that are granted
    cleared    -- number of the first drive that is not cleared, and its cleared fraction
    is_between -- the robot stands between two vertices, on the first drive that is not released
    """

    kind: RobotType
    plan: Sequence[Drive]
    released: int = 0
    cleared: Tuple[int, float] = (0, 0.0)
    is_between: bool = False


class EdgeGroup(NamedTuple):
    """Drives of two robots that must all be driven in one order, or all in the reverse order.

    constraints -- the conditions with which `first` goes before `then`
    reverse     -- the conditions with which `then` goes before `first`; empty: this is impossible
    """

    first: str
    then: str
    constraints: Tuple[Constraint, ...]
    reverse: Tuple[Constraint, ...]


class _Drives(NamedTuple):
    """The remaining drives of all robots, as columns."""

    robot: np.ndarray      # (N,) number in the order of the robots' names
    number: np.ndarray     # (N,) within the robot's plan
    drive: np.ndarray      # (N,)
    rank: np.ndarray       # (N,) number in the order of the plans' times
    cleared: np.ndarray    # (N,) 0..1
    released: np.ndarray   # (N,) whether the drive is released
    is_next: np.ndarray    # (N,) whether it is the first drive that is not released
    is_between: np.ndarray  # (N,) whether the robot stands on it
    is_last: np.ndarray    # (N,) whether it is the robot's last drive


class _Marks(NamedTuple):
    """M pairs of drives that exclude each other: `first` goes before `then`."""

    first: np.ndarray        # (M,) index into _Drives
    then: np.ndarray         # (M,)
    first_clear: np.ndarray  # (M,) the fraction after which `first` is clear of `then`
    then_clear: np.ndarray   # (M,)
    fixed: np.ndarray        # (M,) whether the order of the pair is fixed


def edge_groups(network: RoadNetwork, clearance: float,
              fleet: Mapping[str, RobotProgress]) -> List[EdgeGroup]:
    """Returns all groups of the remaining plans.

    Their constraints are as safe as the constraints of `precedence`.
    """
    names = sorted(name for name, one in fleet.items() if one.cleared[0] < len(one.plan))
    if len(names) < 2:
        return []
    drives = _rest([fleet[name] for name in names])
    kinds = [fleet[name].kind for name in names]
    number = np.array([list(dict.fromkeys(kinds)).index(kind) for kind in kinds])[drives.robot]
    found = [_marks(network, clearance, drives, one, other, number == k, number == j)
             for k, one in enumerate(dict.fromkeys(kinds))
             for j, other in enumerate(dict.fromkeys(kinds))]
    marks = _Marks(*map(np.concatenate, zip(*found)))
    return _groups(names, drives, marks)


def _rest(fleet: Sequence[RobotProgress]) -> _Drives:
    rows = [(robot, k, drive.drive, drive.start, drive.end,
             one.cleared[1] if k == one.cleared[0] else 0.0, k < one.released, k == one.released,
             k == one.released and one.is_between, k == len(one.plan) - 1)
            for robot, one in enumerate(fleet)
            for k, drive in enumerate(one.plan[one.cleared[0]:], one.cleared[0])]
    table = np.array(rows, dtype=float)
    robot, number, drive, start, end, cleared, released, is_next, is_between, is_last = table.T
    order = np.lexsort((number, robot, end, start, -released))
    rank = np.empty(len(rows), dtype=np.int64)
    rank[order] = np.arange(len(rows))
    return _Drives(robot.astype(np.int64), number.astype(np.int64), drive.astype(np.int64), rank,
                   cleared, released > 0.0, is_next > 0.0, is_between > 0.0, is_last > 0.0)


def _marks(network: RoadNetwork, clearance: float, drives: _Drives, kind: RobotType,
           other_kind: RobotType, of_kind: np.ndarray, of_other: np.ndarray) -> _Marks:
    """Returns the marks between robots of type `kind` and later robots of type `other_kind`.

    Robots are ordered by their names.
    """
    conflicts = network.exclusions.at(kind.reach + other_kind.reach + clearance)
    one = np.flatnonzero(of_kind)
    place = network.vertices + (drives.drive[one] >> 1)
    lengths = conflicts.starts[place + 1] - conflicts.starts[place]
    at = np.repeat(conflicts.starts[place], lengths) + count_up(lengths)
    one = np.repeat(one, lengths)
    # Each edge that one of these drives excludes, with all drives on this edge.
    other = np.flatnonzero(of_other)
    other = other[np.argsort(drives.drive[other] >> 1, kind='stable')]
    edges = drives.drive[other] >> 1
    edge = conflicts.other[at] - network.vertices
    low, high = np.searchsorted(edges, edge), np.searchsorted(edges, edge, 'right')
    used = np.where(edge >= 0, high - low, 0)
    other = other[np.repeat(low, used) + count_up(used)]
    one, at = np.repeat(one, used), np.repeat(at, used)
    keep = drives.robot[one] < drives.robot[other]
    one, other, at = one[keep], other[keep], at[keep]

    def clear(drive: np.ndarray, pair: np.ndarray) -> np.ndarray:
        return np.where(drives.drive[drive] % 2 == 0, conflicts.forward[pair],
                        conflicts.backward[pair])

    one_clear, other_clear = clear(one, at), clear(other, conflicts.transpose[at])
    left = (one_clear > drives.cleared[one]) & (other_clear > drives.cleared[other])
    one, other, one_clear, other_clear = (
        column[left] for column in (one, other, one_clear, other_clear))
    earlier = drives.rank[one] < drives.rank[other]
    marks = _Marks(np.where(earlier, one, other), np.where(earlier, other, one),
                   np.where(earlier, one_clear, other_clear),
                   np.where(earlier, other_clear, one_clear), np.zeros(len(one), dtype=bool))
    return marks._replace(fixed=_fixed(network, drives, marks, conflicts.row))


def _fixed(network: RoadNetwork, drives: _Drives, marks: _Marks,
           row: Callable[[int], List[int]]) -> np.ndarray:
    """Returns the pairs of drives whose order cannot be reversed.

    The order is fixed if

    - one of the drives is released,
    - the robot that goes first already stands in the way of the other robot, or
    - the other robot would end in the way of the first robot.
    """
    first, then = marks.first, marks.then
    fixed = drives.released[first] | drives.released[then] | drives.is_between[first]
    excluded: Dict[int, frozenset] = {}

    def excludes(vertex: int, drive: int) -> bool:
        if vertex not in excluded:
            excluded[vertex] = frozenset(row(vertex))
        return network.vertices + (drive >> 1) in excluded[vertex]

    for k in map(int, np.flatnonzero(~fixed & (drives.is_next[first] | drives.is_last[then]))):
        one, other = int(drives.drive[first[k]]), int(drives.drive[then[k]])
        fixed[k] = (drives.is_next[first[k]] and excludes(network.origin[one], other)
                    or drives.is_last[then[k]] and excludes(network.destination(other), one))
    return fixed


def _groups(names: Sequence[str], drives: _Drives, marks: _Marks) -> List[EdgeGroup]:
    count = len(marks.first)
    if not count:
        return []
    one, other = drives.robot[marks.first], drives.robot[marks.then]
    before, then = drives.number[marks.first], drives.number[marks.then]
    width = int(drives.number.max()) + 2
    key = ((one * len(names) + other) * width + before) * width + then
    order = np.argsort(key)
    key = key[order]
    joined = []
    for step, side in _TOUCHING:
        touching: np.ndarray = key + step * width + side
        end = np.searchsorted(key, touching)
        hit = key[np.minimum(end, count - 1)] == touching
        joined.append((np.flatnonzero(hit), end[hit]))
    row, column = (np.concatenate(side) for side in zip(*joined))
    group = np.empty(count, dtype=np.int64)
    groups, group[order] = connected_components(
        coo_matrix((np.ones(len(row)), (row, column)), (count, count)), directed=False)
    fixed = np.zeros(groups, dtype=bool)
    fixed[group[marks.fixed]] = True
    pairs = np.zeros((groups, 2), dtype=np.int64)
    pairs[group, 0], pairs[group, 1] = one, other
    kept: List[List[Constraint]] = [[] for _ in range(groups)]
    reverse: List[List[Constraint]] = [[] for _ in range(groups)]
    for k in map(int, _needed(group, before, marks.first_clear, then)):
        kept[group[k]].append(Constraint(names[one[k]], int(before[k]),
                                            float(marks.first_clear[k]), names[other[k]],
                                            int(then[k])))
    loose = np.flatnonzero(~fixed[group])
    for k in map(int, loose[_needed(group[loose], then[loose], marks.then_clear[loose],
                                    before[loose])]):
        reverse[group[k]].append(Constraint(names[other[k]], int(then[k]),
                                               float(marks.then_clear[k]), names[one[k]],
                                               int(before[k])))
    return [EdgeGroup(names[a], names[b], tuple(kept[k]), tuple(reverse[k]))
            for k, (a, b) in enumerate(pairs)]


def _needed(group: np.ndarray, before: np.ndarray, clear: np.ndarray,
            then: np.ndarray) -> np.ndarray:
    """Returns for each group the marks whose conditions do not follow from the marks of earlier
    drives.
    """
    if not len(group):
        return np.zeros(0, dtype=np.int64)
    by_demand = np.lexsort((clear, before))
    more = (np.diff(before[by_demand]) != 0) | (np.diff(clear[by_demand]) != 0.0)
    demand = np.zeros(len(before), dtype=np.int64)
    demand[by_demand[1:]] = np.cumsum(more)
    order = np.lexsort((-demand, then, group))
    most = np.maximum.accumulate(demand[order] + group[order] * (len(order) + 1))
    needed: np.ndarray = np.sort(order[np.concatenate(([True], np.diff(most) > 0))])
    return needed
