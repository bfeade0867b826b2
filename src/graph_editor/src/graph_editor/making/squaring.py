"""Right corners for cut ones: where a skeleton slants from one straight lane to another.

A slanting lane between a lane along one axis and a lane across it gives way to the corner in which
the two meet when they are drawn on.
"""
from __future__ import annotations

import math
from typing import Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from graph_editor.making.lanes import Lane, LaneNet
from graph_editor.making.rectifying import axis_of
from graph_editor.making.sight import in_sight

LONGEST_SLANT = 3.5  # m
FARTHEST_CORNER = 3.0  # m from either end of the slant
CLOSE = 0.6  # m between nodes that become one
STRAIGHT = math.radians(6.0)  # of turning, at a node that is none


class _Corner(NamedTuple):
    """What would take the place of a slant."""

    way: float  # m, from one end of the slant to the other by the corner
    position: np.ndarray
    slant: Lane
    split: Optional[Lane]  # the lane that the corner lies on


def square_corners(net: LaneNet, axes: Sequence[float]) -> None:
    """Replaces slants, one after the other, as long as there are any to replace."""
    refused = set()
    while True:
        slants = sorted((lane for lane in net.lanes if lane.nodes not in refused
                         and _is_slant(net, lane, axes)), key=lambda lane: (net.length(lane), lane.nodes))
        for slant in slants:
            corner = min(_corners(net, slant, axes), key=lambda corner: corner.way, default=None)
            if corner is not None:
                _draw(net, corner)
                break
            refused.add(slant.nodes)
        else:
            return


def _is_slant(net: LaneNet, lane: Lane, axes: Sequence[float]) -> bool:
    length = net.length(lane)
    return length < LONGEST_SLANT and axis_of(_direction(net, *lane.nodes), length, axes) is None


def _direction(net: LaneNet, start: int, end: int) -> float:
    dx, dy = net.positions[end] - net.positions[start]
    return math.atan2(dy, dx)


def _corners(net: LaneNet, slant: Lane, axes: Sequence[float]) -> Iterator[_Corner]:
    """The corners that could replace a slant, all of them free."""
    a, b = slant.nodes
    for near, along in _straight_lanes(net, a, b, axes):
        for far, across in _straight_lanes(net, b, a, axes):
            if abs(math.cos(along - across)) > 0.1:
                continue
            corner = _crossing(net.positions[a], along, net.positions[b], across)
            made = _corner(net, slant, corner, near, far)
            if made is not None:
                yield made


def _straight_lanes(net: LaneNet, node: int, without: int,
                    axes: Sequence[float]) -> Iterator[Tuple[Lane, float]]:
    """The lanes at a node that follow an axis, and its direction."""
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
    return _Corner(sum(ways), corner, slant, near if on_near else far if on_far else None)


def _lies_on(net: LaneNet, position: np.ndarray, lane: Lane) -> bool:
    a, b = net.ends(lane)
    along = b - a
    fraction = float((position - a) @ along / (along @ along))
    return 0.0 < fraction < 1.0


def _draw(net: LaneNet, corner: _Corner) -> None:
    a, b = corner.slant.nodes
    net.remove_lane(corner.slant)
    ends = [a, b]
    if corner.split is not None:
        ends = [node for node in ends if node not in corner.split.nodes]
        node = net.split(corner.split, corner.position)
    else:
        node = net.add_node(corner.position)
    for end in ends:
        net.add_lane(end, node, corner.slant.need,
                     np.array((net.positions[end], net.positions[node])))


def tidy(net: LaneNet, keep: Sequence[int] = ()) -> None:
    """Makes one of nodes close together, and takes out nodes on a straight way; all stays free."""
    _merge_close(net, set(keep))
    _dissolve_straight(net, set(keep))


def _merge_close(net: LaneNet, keep: set) -> None:
    refused = set()
    while True:
        short = [(net.length(lane), lane.nodes) for lane in net.lanes
                 if net.length(lane) < CLOSE and lane.nodes not in refused]
        if not short:
            return
        _, (a, b) = min(short)
        if not _merge(net, a, b, keep):
            refused.add((a, b))


def _merge(net: LaneNet, a: int, b: int, keep: set) -> bool:
    for node, other in ((a, b), (b, a)) if net.degree(a) >= net.degree(b) else ((b, a), (a, b)):
        if other in keep:
            continue
        around = [net.lane(other, neighbour) for neighbour in net.neighbours(other)
                  if neighbour != node]
        starts = [(net.positions[next(n for n in lane.nodes if n != other)], lane.need)
                  for lane in around]
        if all(in_sight(net.floor, start, net.positions[node], need) for start, need in starts):
            net.merge(node, other)
            return True
    return False


def _dissolve_straight(net: LaneNet, keep: set) -> None:
    for node in net.nodes:
        if node in keep or net.degree(node) != 2:
            continue
        a, b = net.neighbours(node)
        turn = math.remainder(_direction(net, node, b) - _direction(net, a, node), 2.0 * math.pi)
        need = min(net.lane(a, node).need, net.lane(node, b).need)
        if abs(turn) < STRAIGHT and in_sight(net.floor, net.positions[a], net.positions[b], need):
            first, second = net.lane(a, node), net.lane(node, b)
            samples = np.vstack((_from(first, a), _from(second, node)))
            net.remove_node(node)
            net.add_lane(a, b, need, samples)


def _from(lane: Lane, node: int) -> np.ndarray:
    return lane.samples if lane.nodes[0] == node else lane.samples[::-1]
