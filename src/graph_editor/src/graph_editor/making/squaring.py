"""Replaces slanting lanes, which arise where the skeleton cuts corners, by lanes along the axes.

- A slant that connects two perpendicular lanes is replaced by the corner at which the extensions of
  these lanes meet.
- If a slant ends at a lane that is perpendicular to the slant's nearest axis, the slant is moved
  and then meets this lane at a right angle.
- A slant that is a dead end is turned to an axis.
"""
from __future__ import annotations

import math
from typing import Iterator, NamedTuple, Optional, Sequence, Set, Tuple

import numpy as np

from graph_editor.making.lanes import Lane, LaneNet
from graph_editor.making.rectifying import axis_of
from graph_editor.making.sight import in_sight

LONGEST_CUT = 3.5  # m; largest length of a slant that cuts a corner
FARTHEST_CORNER = 3.0  # m; largest distance of the corner from the ends of the slant
LONGEST_SLANT = 12.0  # m; longer lanes are not slants
STEEPEST = math.radians(40.0)  # largest angle between a slant and the axis to which it is moved
FARTHEST_SHIFT = 2.5  # m; largest movement of the end of a slant
CLOSE = 0.6  # m; a lane that would end within this distance of a node ends at the node


class _Corner(NamedTuple):
    """A corner that can replace a slant."""

    way: float  # m; length of the path through the corner, from one end of the slant to the other
    position: np.ndarray
    slant: Lane
    split: Optional[Lane]  # the lane on which the corner is
    ends: Tuple[int, ...]  # the nodes that are joined to the corner


def square(net: LaneNet, axes: Sequence[float]) -> None:
    """Replaces slants, the shortest slant first. Each slant is tried once."""
    refused: Set[Tuple[int, int]] = set()
    for _ in range(2 * len(net.lanes)):
        slant = min((lane for lane in net.lanes if lane.nodes not in refused
                     and _is_slant(net, lane, axes)),
                    key=lambda lane: (net.length(lane), lane.nodes), default=None)
        if slant is None:
            return
        refused.add(slant.nodes)  # do not try the same slant again
        corner = min([*_corners(net, slant, axes), *_levelled(net, slant, axes)],
                     key=lambda corner: corner.way, default=None)
        if corner is not None:
            _draw(net, corner)
        elif 1 in (net.degree(node) for node in slant.nodes):
            _turn(net, slant, axes)


def _is_slant(net: LaneNet, lane: Lane, axes: Sequence[float]) -> bool:
    length = net.length(lane)
    return length < LONGEST_SLANT and axis_of(_direction(net, *lane.nodes), length, axes) is None


def _nearest_axis(direction: float, axes: Sequence[float]) -> float:
    """Returns the direction (rad), along or across one of the axes, that is nearest to
    `direction`.
    """
    along = [axis + round((direction - axis) / (math.pi / 2.0)) * math.pi / 2.0 for axis in axes]
    return min(along, key=lambda candidate: abs(candidate - direction))


def _direction(net: LaneNet, start: int, end: int) -> float:
    dx, dy = net.positions[end] - net.positions[start]
    return math.atan2(dy, dx)


def _corners(net: LaneNet, slant: Lane, axes: Sequence[float]) -> Iterator[_Corner]:
    """Yields the free corners that a slant cuts and that could replace the slant."""
    a, b = slant.nodes
    if net.length(slant) > LONGEST_CUT:
        return
    for near, along in _straight_lanes(net, a, b, axes):
        for far, across in _straight_lanes(net, b, a, axes):
            if abs(math.cos(along - across)) > 0.1:
                continue
            corner = _crossing(net.positions[a], along, net.positions[b], across)
            made = _corner(net, slant, corner, near, far)
            if made is not None:
                yield made


def _levelled(net: LaneNet, slant: Lane, axes: Sequence[float]) -> Iterator[_Corner]:
    """Yields the places on a lane or its extension at which a slant could end at a right angle."""
    for start, end in (slant.nodes, slant.nodes[::-1]):
        direction = _direction(net, start, end)
        along = _nearest_axis(direction, axes)
        if abs(along - direction) > STEEPEST:
            continue
        for lane, across in _straight_lanes(net, end, start, axes):
            if abs(math.cos(along - across)) > 0.1:
                continue
            corner = _crossing(net.positions[start], along, net.positions[end], across)
            shift = float(np.hypot(*(corner - net.positions[end])))
            beyond = next(node for node in lane.nodes if node != end)
            if np.hypot(*(corner - net.positions[beyond])) < CLOSE:
                corner = net.positions[beyond]
            if shift > FARTHEST_SHIFT or not in_sight(net.floor, net.positions[start], corner,
                                                      slant.need):
                continue
            if corner is net.positions[beyond]:
                yield _Corner(shift, corner, slant, None, (start, beyond))
            elif _lies_on(net, corner, lane):
                yield _Corner(shift, corner, slant, lane, (start,))
            elif in_sight(net.floor, net.positions[end], corner, slant.need):
                yield _Corner(shift, corner, slant, None, (start, end))


def _turn(net: LaneNet, slant: Lane, axes: Sequence[float]) -> None:
    """Turns a dead end about its start, to the nearest axis along which the lane has enough
    clearance.
    """
    base, tip = sorted(slant.nodes, key=net.degree, reverse=True)
    direction, length = _direction(net, base, tip), net.length(slant)
    turns = sorted((abs(math.remainder(axis + quarter * math.pi / 2.0 - direction, 2.0 * math.pi)),
                    axis + quarter * math.pi / 2.0) for axis in axes for quarter in range(4))
    for turn, along in turns:
        if turn > math.pi / 4.0 + 0.01:
            return
        end = net.positions[base] + length * math.cos(turn) * np.array((math.cos(along),
                                                                        math.sin(along)))
        if in_sight(net.floor, net.positions[base], end, slant.need):
            net.remove_lane(slant)
            net.positions[tip] = end
            net.add_lane(base, tip, slant.need, np.array((net.positions[base], end)))
            return


def _straight_lanes(net: LaneNet, node: int, without: int,
                    axes: Sequence[float]) -> Iterator[Tuple[Lane, float]]:
    """Yields the lanes at a node that follow an axis, and the direction of the axis."""
    for other in net.neighbours(node):
        if other != without:
            lane = net.lane(node, other)
            along = axis_of(_direction(net, node, other), net.length(lane), axes)
            if along is not None and net.length(lane) > 0.8:
                yield lane, along


def _crossing(a: np.ndarray, along: float, b: np.ndarray, across: float) -> np.ndarray:
    matrix = np.array(((math.cos(along), -math.cos(across)), (math.sin(along), -math.sin(across))))
    return a + np.linalg.solve(matrix, b - a)[0] * matrix[:, 0]


def _corner(net: LaneNet, slant: Lane, corner: np.ndarray, near: Lane,
            far: Lane) -> Optional[_Corner]:
    a, b = (net.positions[node] for node in slant.nodes)
    ways = [float(np.hypot(*(corner - end))) for end in (a, b)]
    if max(ways) > FARTHEST_CORNER:
        return None
    on_near, on_far = _lies_on(net, corner, near), _lies_on(net, corner, far)
    if on_near and on_far:
        return None
    for end, is_on in ((a, on_near), (b, on_far)):
        if not is_on and not in_sight(net.floor, end, corner, slant.need):
            return None
    split = near if on_near else far if on_far else None
    ends = tuple(node for node in slant.nodes if split is None or node not in split.nodes)
    return _Corner(sum(ways), corner, slant, split, ends)


def _lies_on(net: LaneNet, position: np.ndarray, lane: Lane) -> bool:
    a, b = net.ends(lane)
    along = b - a
    fraction = float((position - a) @ along / (along @ along))
    return 0.0 < fraction < 1.0


def _draw(net: LaneNet, corner: _Corner) -> None:
    net.remove_lane(corner.slant)
    *ends, last = corner.ends
    if corner.split is not None:
        ends.append(last)
        last = net.split(corner.split, corner.position)
    elif corner.position is not net.positions[last]:
        ends.append(last)
        last = net.add_node(corner.position)
    for end in ends:
        net.add_lane(end, last, corner.slant.need,
                     np.array((net.positions[end], net.positions[last])))
