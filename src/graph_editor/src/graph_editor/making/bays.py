"""Adds bays: short lanes that leave other lanes at right angles, into floor far from all lanes."""
from __future__ import annotations

import math
from typing import Iterator, List, Optional, Sequence, Tuple

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from graph_editor.floor import EVERY_NEIGHBOUR
from graph_editor.making.coverage import Coverage, dense
from graph_editor.making.lanes import LaneNet, LaneOrNode
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import TOLERANCE

LEAST_FLOOR = 0.6  # m2; least floor that a bay must serve
PER_METRE = 0.4  # m2; additional floor that a bay must serve for each metre of its length
LONGEST = 8.0  # m; largest length of a bay
STEP = 0.5  # m; distance between the places at which a bay may begin
FROM_NODE = 0.8  # m; a bay that would start nearer to a node starts at the node


def add_bays(net: LaneNet, coverage: Coverage, axes: Sequence[float],
             options: MakingOptions) -> None:
    """Adds bays, the most useful bay first, until no further bay is useful.

    If the net has only one node and no lanes, bays lead from this node along the `axes` (rad).
    """
    far = coverage.mask.copy()
    for node in net.nodes:
        far.flat[coverage.covered_by(net.positions[node][None, :])] = False
    for lane in net.lanes:
        far.flat[coverage.covered_by(np.array(net.ends(lane)))] = False
    while True:
        parts, count = ndimage.label(far, EVERY_NEIGHBOUR)
        if not count:
            return
        areas = np.bincount(parts.ravel())[1:] * coverage.cell_area
        part = int(np.argmax(areas)) + 1
        if areas[part - 1] < LEAST_FLOOR:
            return
        unserved = coverage.points_of(*np.nonzero(parts == part))
        bay = _best_bay(net, unserved, coverage, axes, options)
        if bay is None:
            far[parts == part] = False
        else:
            _draw(net, *bay)
            far.flat[coverage.covered_by(np.array(bay[1:]))] = False


def _best_bay(net: LaneNet, floor: np.ndarray, coverage: Coverage, axes: Sequence[float],
              options: MakingOptions) -> Optional[Tuple[LaneOrNode, np.ndarray, np.ndarray]]:
    """Returns the most useful bay for `floor` (N,2): the lane or node that it leaves, its start and
    its end.
    """
    unserved = cKDTree(floor)
    best: Tuple[float, Optional[Tuple[LaneOrNode, np.ndarray, np.ndarray]]] = (0.0, None)
    for root, start, direction in _beginnings(net, axes):
        if unserved.query(start)[0] > LONGEST + options.reach:
            continue
        lengths = np.arange(STEP, LONGEST, STEP / 2.0)
        points = start + lengths[:, None] * direction
        blocked = net.floor.clearance_at(points) < options.wide - TOLERANCE
        free = int(np.argmax(blocked)) if blocked.any() else len(points)
        served = np.zeros(len(floor), bool)
        for length, point in zip(lengths[:free], points[:free]):
            served[unserved.query_ball_point(point, options.reach)] = True
            gain = served.sum() * coverage.cell_area - LEAST_FLOOR - PER_METRE * length
            if length >= 1.0 and gain > best[0] + 1e-9:
                best = gain, (root, start, point)
    return best[1]


def _beginnings(net: LaneNet,
                axes: Sequence[float]) -> Iterator[Tuple[LaneOrNode, np.ndarray, np.ndarray]]:
    """Yields the possible starts of bays: a lane or node, a position on it, and a direction."""
    for node in net.nodes:
        if net.degree(node) == 0:
            for axis in axes:
                for quarter in range(4):
                    angle = axis + quarter * math.pi / 2.0
                    yield node, net.positions[node], np.array((math.cos(angle), math.sin(angle)))
    for lane in net.lanes:
        a, b = net.ends(lane)
        length = net.length(lane)
        if length < 0.1:
            continue
        along = (b - a) / length
        across = np.array((-along[1], along[0]))
        for s in np.arange(FROM_NODE, length - FROM_NODE + 1e-9, STEP):
            for side in (across, -across):
                yield lane, a + s * along, side
        for node, onward in ((lane.nodes[0], -along), (lane.nodes[1], along)):
            for direction in (onward, across, -across):
                if _is_open(net, node, direction):
                    yield node, net.positions[node], direction


def _is_open(net: LaneNet, node: int, direction: np.ndarray) -> bool:
    """Returns whether no lane leads from the node in about this direction."""
    here = net.positions[node]
    for other in net.neighbours(node):
        away = net.positions[other] - here
        if away @ direction > 0.5 * np.hypot(*away):
            return False
    return True


def _draw(net: LaneNet, root: LaneOrNode, start: np.ndarray, end: np.ndarray) -> None:
    node = net.joint(root, start)
    tip = net.add_node(end)
    need = float(net.floor.clearance_at(dense(np.array((start, end)), 0.05)).min())
    net.add_lane(node, tip, need, np.array((start, end)))


def dead_ends(net: LaneNet) -> List[int]:
    """Returns the nodes with exactly one lane."""
    return [node for node in net.nodes if net.degree(node) == 1]
