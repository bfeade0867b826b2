"""Adds lattices: crossing lanes in wide halls, which replace the lanes in the middle of these
halls.
"""
from __future__ import annotations

import math
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
from scipy import ndimage

from graph_editor.floor import EVERY_NEIGHBOUR, Floor
from graph_editor.making.lanes import Lane, LaneNet, LaneOrNode
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import in_sight, straight

NEAR_NODE = 0.8  # m; a lane from outside that would end this near to a node ends at the node


def add_lattices(net: LaneNet, axes: Sequence[float], options: MakingOptions) -> LaneNet:
    """Returns `net` with a lattice in each hall.

    A hall does not change if the lanes that lead to the hall cannot be joined to its lattice.
    """
    for hall in _halls(net.floor, options):
        made = net.copy()
        counts = [len(_lattice(net.copy(), hall, axis, options)) for axis in axes]
        axis = axes[int(np.argmax(counts))]
        tips = _cut_out(made, hall)
        nodes = _lattice(made, hall, axis, options)
        joined = len(nodes) >= 4 and all(_join(made, tip, direction, nodes, options)
                                         for tip, direction in tips)
        if joined and len(list(made.components())) <= len(list(net.components())):
            net = made
    return net


def _halls(floor: Floor, options: MakingOptions) -> List[np.ndarray]:
    """Returns the masks of the wide places.

    In the middle of a wide place the clearance is at least the pitch of the lattice.
    """
    core = floor.clearance >= options.lattice_pitch
    near = ndimage.distance_transform_edt(~core) * floor.resolution < options.lattice_pitch
    parts, count = ndimage.label(near & (floor.clearance >= options.wide), EVERY_NEIGHBOUR)
    return [parts == part for part in range(1, count + 1) if core[parts == part].any()]


def _lattice(net: LaneNet, hall: np.ndarray, axis: float, options: MakingOptions) -> List[int]:
    """Adds the lattice of a hall along an axis (rad) to the net. Returns its nodes, which are all
    connected.
    """
    floor = net.floor
    turn = np.array(((math.cos(axis), -math.sin(axis)), (math.sin(axis), math.cos(axis))))
    cells = floor.centres(*np.nonzero(hall)) @ turn
    low, high = cells.min(axis=0), cells.max(axis=0)
    lines = []
    for side in (0, 1):
        count = max(1, math.ceil((high[side] - low[side]) / options.lattice_pitch - 1e-6))
        lines.append(low[side] + (np.arange(count) + 0.5) * (high[side] - low[side]) / count)
    places: Dict[Tuple[int, int], np.ndarray] = {}
    for i, u in enumerate(lines[0]):
        for j, v in enumerate(lines[1]):
            place = turn @ (u, v)
            if _inside(floor, hall, place):
                places[i, j] = place
    joined: Dict[Tuple[int, int], List[Tuple[int, int]]] = {key: [] for key in places}
    for i, j in places:
        for other in ((i + 1, j), (i, j + 1)):
            if other in places and in_sight(floor, places[i, j], places[other], options.wide):
                joined[i, j].append(other)
                joined[other].append((i, j))
    chosen = _largest_part(joined)
    nodes = {key: net.add_node(places[key]) for key in chosen}
    for key in chosen:
        for other in joined[key]:
            if key < other:
                net.add_lane(nodes[key], nodes[other], options.wide,
                             np.array((places[key], places[other])))
    return list(nodes.values())


def _inside(floor: Floor, hall: np.ndarray, place: np.ndarray) -> bool:
    (row,), (column,) = floor.cells_of(place[None, :])
    return bool(hall[row, column])


def _largest_part(joined: Dict[Tuple[int, int], List[Tuple[int, int]]]) -> List[Tuple[int, int]]:
    best: List[Tuple[int, int]] = []
    left = set(joined)
    for start in joined:
        if start not in left:
            continue
        part, waiting = {start}, [start]
        while waiting:
            for other in joined[waiting.pop()]:
                if other not in part:
                    part.add(other)
                    waiting.append(other)
        left -= part
        if len(part) > len(best):
            best = sorted(part)
    return best


def _cut_out(net: LaneNet, hall: np.ndarray) -> List[Tuple[int, np.ndarray]]:
    """Removes the parts of lanes in the hall. Returns the nodes at the cut ends, and the directions
    from there into the hall.
    """
    tips = []
    for lane in net.lanes:
        points = straight(net.floor, *net.ends(lane))
        rows, columns = net.floor.cells_of(points)
        inside = hall[rows, columns]
        if not inside.any():
            continue
        net.remove_lane(lane)
        along = (points[-1] - points[0]) / max(np.hypot(*(points[-1] - points[0])), 1e-9)
        first, last = np.flatnonzero(inside)[[0, -1]]
        for node, entry, direction in ((lane.nodes[0], int(first), along),
                                       (lane.nodes[1], int(last), -along)):
            if not _inside(net.floor, hall, net.positions[node]):
                tip = net.add_node(points[entry])
                net.add_lane(node, tip, lane.need, np.array((net.positions[node], points[entry])))
                tips.append((tip, direction))
    for node in net.nodes:
        if net.degree(node) == 0 and _inside(net.floor, hall, net.positions[node]):
            net.remove_node(node)
    return tips


def _join(net: LaneNet, tip: int, direction: np.ndarray, nodes: Sequence[int],
          options: MakingOptions) -> bool:
    """Connects a lane from outside to the lattice, straight if possible. Returns whether it
    succeeded.
    """
    here = net.positions[tip]
    lattice = set(nodes)
    ways: List[Tuple[float, int, np.ndarray, LaneOrNode]] = []
    for lane in net.lanes:
        if not set(lane.nodes) <= lattice:
            continue
        a, b = net.ends(lane)
        crossing = _crossing(here, direction, a, b)
        if crossing is not None:
            ways.append((float(np.hypot(*(crossing - here))) - options.lattice_pitch, len(ways),
                         crossing, lane))
    for node in nodes:
        distance = float(np.hypot(*(net.positions[node] - here)))
        ways.append((distance, len(ways), net.positions[node], node))
    for _, _, place, target in sorted(ways, key=lambda way: way[:2]):
        if np.hypot(*(place - here)) > 2.0 * options.lattice_pitch:
            continue
        if isinstance(target, Lane):
            distance, near = min((float(np.hypot(*(net.positions[end] - place))), end)
                                 for end in target.nodes)
            if distance < NEAR_NODE:
                place, target = net.positions[near], near
        if not in_sight(net.floor, here, place, options.wide):
            continue
        net.add_lane(tip, net.joint(target, place), options.wide, np.array((here, place)))
        return True
    return False


def _crossing(here: np.ndarray, direction: np.ndarray, a: np.ndarray,
              b: np.ndarray) -> Optional[np.ndarray]:
    """Returns the point at which a ray from `here` meets the line from `a` to `b`, or None."""
    along = b - a
    cross = direction[0] * along[1] - direction[1] * along[0]
    if abs(cross) < 1e-9:
        return None
    between = a - here
    ahead = (between[0] * along[1] - between[1] * along[0]) / cross
    share = (between[0] * direction[1] - between[1] * direction[0]) / cross
    return here + ahead * direction if ahead > 0.05 and 0.0 <= share <= 1.0 else None
