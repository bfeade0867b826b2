"""Reduces the number of nodes and lanes: merges near nodes, and joins lanes that form a straight
line.

Each lane keeps the clearance that it needs.
"""
from __future__ import annotations

import math
from typing import Collection, Optional, Tuple

import numpy as np

from graph_editor.making.coverage import Coverage, dense
from graph_editor.making.lanes import Lane, LaneNet
from graph_editor.making.sight import in_sight

CLOSE = 0.6  # m; nodes within this distance are merged
TOUCHING = 0.35  # m; a lane that passes a node within this distance is led through the node
STRAIGHT = math.radians(6.0)  # if the turn at a node is smaller, the node is unnecessary
LEAST_FLOOR = 1.5  # m2; a dead end stays if it alone serves this much floor


def tidy(net: LaneNet, keep: Collection[int] = (), turning: float = 0.0) -> None:
    """Tidies the net. The nodes to `keep` do not move, but other nodes may be merged into them.

    New bends are made only at places with a clearance of at least `turning` m.
    """
    kept = set(keep)
    _cross(net)
    _lead_through(net, turning)
    _merge_close(net, kept, turning)
    _dissolve_straight(net, kept)


def prune_tails(net: LaneNet, coverage: Coverage, turning: float) -> None:
    """Removes dead ends, the least useful first, if other lanes serve almost all floor that they
    serve.

    A lane stays if the dead end without it would end at a place where robots cannot turn.
    """
    served = {lane.nodes: coverage.covered_by(dense(np.array(net.ends(lane)), 0.05))
              for lane in net.lanes}
    servants = np.zeros(coverage.mask.size, np.int32)
    for cells in served.values():
        servants[cells] += 1
    while len(net.lanes) > 1:
        useless = [(coverage.left_without(servants, served[lane.nodes]), tip, lane.nodes)
                   for lane in net.lanes for tip, base in (lane.nodes, lane.nodes[::-1])
                   if net.degree(tip) == 1 and not _ends_narrow(net, base, turning)]
        loss, tip, lane_nodes = min(useless, default=(math.inf, 0, (0, 0)))
        if loss >= LEAST_FLOOR:
            return
        servants[served.pop(lane_nodes)] -= 1
        net.remove_node(tip)


def _ends_narrow(net: LaneNet, node: int, turning: float) -> bool:
    """Returns whether a dead end at this node would have no space for robots to turn."""
    return net.degree(node) == 2 and net.floor.clearance_of(net.positions[node]) < turning


def _cross(net: LaneNet) -> None:
    """Adds nodes at the crossings of lanes."""
    while True:
        found = _crossing(net)
        if found is None:
            return
        first, second, position = found
        node = net.split(first, position)
        other = net.split(second, position)
        net.merge(node, other)


def _crossing(net: LaneNet) -> Optional[Tuple[Lane, Lane, np.ndarray]]:
    lanes = net.lanes
    if len(lanes) < 2:
        return None
    ends = np.array([net.ends(lane) for lane in lanes])
    starts, steps = ends[:, 0], ends[:, 1] - ends[:, 0]
    for i, lane in enumerate(lanes[:-1]):
        ahead = slice(i + 1, len(lanes))
        between = starts[ahead] - starts[i]
        cross = steps[i, 0] * steps[ahead, 1] - steps[i, 1] * steps[ahead, 0]
        with np.errstate(divide='ignore', invalid='ignore'):
            mine = (between[:, 0] * steps[ahead, 1] - between[:, 1] * steps[ahead, 0]) / cross
            theirs = (between[:, 0] * steps[i, 1] - between[:, 1] * steps[i, 0]) / cross
            inner = ((np.abs(cross) > 1e-9) & (mine > 1e-6) & (mine < 1.0 - 1e-6)
                     & (theirs > 1e-6) & (theirs < 1.0 - 1e-6))
        for k in np.flatnonzero(inner):
            other = lanes[i + 1 + int(k)]
            if not set(lane.nodes) & set(other.nodes):
                return lane, other, starts[i] + mine[k] * steps[i]
    return None


def _lead_through(net: LaneNet, turning: float) -> None:
    """Leads each lane that passes close to another node through this node."""
    again = True
    while again:
        again = False
        for node in net.nodes:
            for lane in net.lanes:
                if (node not in lane.nodes and _passes(net, lane, node)
                        and net.floor.clearance_of(net.positions[node]) >= turning):
                    a, b = lane.nodes
                    net.remove_lane(lane)
                    nearest = int(np.argmin(((lane.samples - net.positions[node]) ** 2
                                             ).sum(axis=1)))
                    net.add_lane(a, node, lane.need, lane.samples[:nearest + 1])
                    net.add_lane(node, b, lane.need, lane.samples[nearest:])
                    again = True


def _passes(net: LaneNet, lane: Lane, node: int) -> bool:
    a, b = net.ends(lane)
    position = net.positions[node]
    along = b - a
    length = float(np.hypot(*along))
    s = float((position - a) @ along) / max(length, 1e-9)
    if not TOUCHING < s < length - TOUCHING:  # nodes that are close together are merged
        return False
    if np.hypot(*(a + s / length * along - position)) > TOUCHING:
        return False
    return all(in_sight(net.floor, end, position, lane.need) for end in (a, b))


def _merge_close(net: LaneNet, keep: set, turning: float) -> None:
    refused = set()
    keep = set(keep)
    while True:
        short = [(net.length(lane), lane.nodes) for lane in net.lanes
                 if net.length(lane) < CLOSE and lane.nodes not in refused]
        if not short:
            return
        _, (a, b) = min(short)
        if not _merge(net, a, b, keep, turning):
            refused.add((a, b))


def _merge(net: LaneNet, a: int, b: int, keep: set, turning: float) -> bool:
    for node, other in ((a, b), (b, a)) if net.degree(a) >= net.degree(b) else ((b, a), (a, b)):
        if other in keep:
            continue
        around = [net.lane(other, neighbour) for neighbour in net.neighbours(other)
                  if neighbour != node]
        starts = [(net.positions[next(n for n in lane.nodes if n != other)], lane.need)
                  for lane in around]
        if around and net.floor.clearance_of(net.positions[node]) < turning:
            continue
        if all(in_sight(net.floor, start, net.positions[node], need) for start, need in starts):
            if not around:
                keep.add(node)  # without this, a bent dead end would be removed node by node
            net.merge(node, other)
            return True
    return not {a, b} & keep and _merge_in_corner(net, a, b, turning)


def _merge_in_corner(net: LaneNet, a: int, b: int, turning: float) -> bool:
    """Replaces two bends by one bend, at the point where the extensions of the two outer lanes
    meet.

    Afterwards these lanes need no more clearance than the lane between the bends needed.
    """
    if net.degree(a) != 2 or net.degree(b) != 2:
        return False
    (before,), (after,) = ([node for node in net.neighbours(end) if node not in (a, b)]
                           for end in (a, b))
    here, there = net.positions[a], net.positions[b]
    first, second = here - net.positions[before], there - net.positions[after]
    cross = float(first[0] * second[1] - first[1] * second[0])
    if before == after or abs(cross) < 0.5 * np.hypot(*first) * np.hypot(*second):
        return False
    between = there - here
    corner = here + (between[0] * second[1] - between[1] * second[0]) / cross * first
    outer = [(net.lane(before, a), net.positions[before]), (net.lane(b, after),
                                                            net.positions[after])]
    need = min(net.lane(a, b).need, *(lane.need for lane, _ in outer))
    if max(np.hypot(*(corner - here)), np.hypot(*(corner - there))) > CLOSE:
        return False
    if net.floor.clearance_of(corner) < turning or not all(
            in_sight(net.floor, far, corner, need) for _, far in outer):
        return False
    for lane, _ in outer:
        net.with_need(lane, need)
    net.positions[a] = corner
    net.merge(a, b)
    return True


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


def _direction(net: LaneNet, start: int, end: int) -> float:
    dx, dy = net.positions[end] - net.positions[start]
    return math.atan2(dy, dx)


def _from(lane: Lane, node: int) -> np.ndarray:
    return lane.samples if lane.nodes[0] == node else lane.samples[::-1]
