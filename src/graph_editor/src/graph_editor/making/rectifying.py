"""Aligns lanes to the directions of the walls, with right angles, in the middle of the floor.

The method is least squares for all nodes at once:
- Each lane should lie on the points of the skeleton that it represents. Narrow places have more
  weight.
- A lane that nearly follows an axis must follow it.
- A condition is dropped for a lane if it would reduce the clearance of this lane too much.
"""
from __future__ import annotations

import math
from typing import Collection, List, Optional, Sequence, Set, Tuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from graph_editor.making.lanes import Lane, LaneNet

NEARLY = math.radians(18.0)  # a lane is aligned to an axis if the angle between them is smaller
SHORT_OFFSET = 0.4  # m; a lane is also aligned if its ends deviate less than this from an axis
FARTHEST = 1.2  # m; largest movement of a node
SAMPLES = 8  # number of points of the skeleton that represent a lane
MUST, HOLD, STAY = 1e4, 1e5, 0.03  # weights: axes, fixed nodes, present node positions
ROUNDS = 60
Key = Tuple[int, int]


def rectify(net: LaneNet, axes: Sequence[float], held: Collection[int] = ()) -> None:
    """Moves the nodes of `net`, except the `held` nodes. A lane that is free stays free."""
    _Rectifier(net, axes, held).run()


def axis_of(direction: float, length: float, axes: Sequence[float]) -> Optional[float]:
    """Returns the direction (rad) of the axis that a lane nearly follows, or None."""
    best = None
    for axis in axes:
        quarters = round((direction - axis) / (math.pi / 2.0))
        along = axis + quarters * math.pi / 2.0
        off = abs(direction - along)
        nearly = off < NEARLY or length * math.sin(off) < SHORT_OFFSET
        if nearly and (best is None or off < best[0]):
            best = off, along
    return None if best is None else best[1]


class _Rectifier:

    def __init__(self, net: LaneNet, axes: Sequence[float], held: Collection[int]) -> None:
        self._net = net
        self._lanes = {lane.nodes: lane for lane in net.lanes}
        self._start = {node: position.copy() for node, position in net.positions.items()}
        self._index = {node: k for k, node in enumerate(net.nodes)}
        self._held = set(held)
        self._places = list(held)
        self._free = {key for key, lane in self._lanes.items() if net.is_free(lane)}
        self._directions = {}
        self._following: Set[Key] = set()
        for key, lane in self._lanes.items():
            a, b = net.ends(lane)
            direction = math.atan2(*(b - a)[::-1])
            along = axis_of(direction, net.length(lane), axes)
            self._directions[key] = direction if along is None else along
            if along is not None:
                self._following.add(key)

    def run(self) -> None:
        for _ in range(ROUNDS):
            self._solve()
            wrong = [key for key in self._free if not self._net.is_free(self._lanes[key])]
            far = [node for node, start in self._start.items()
                   if np.hypot(*(self._net.positions[node] - start)) > FARTHEST]
            if not wrong and not far:
                return
            self._give_up(wrong, far)
        for node, start in self._start.items():
            self._net.positions[node] = start

    def _give_up(self, wrong: List[Key], far: List[int]) -> None:
        """Drops the conditions of wrong lanes. A lane that followed an axis follows it no longer.
        The nodes of any other lane are fixed. All lanes at the nodes `far` count as wrong.
        """
        for node in far:
            wrong += [(min(node, other), max(node, other)) for other in self._net.neighbours(node)]
        for key in set(wrong):
            if key in self._following:
                self._following.discard(key)
                a, b = (self._start[node] for node in key)
                self._directions[key] = math.atan2(*(b - a)[::-1])
            else:
                self._held.update(key)

    def _solve(self) -> None:
        rows: List[int] = []
        columns: List[int] = []
        values: List[float] = []
        wanted: List[float] = []

        def equation(terms: Sequence[Tuple[int, float]], value: float, weight: float) -> None:
            for column, factor in terms:
                rows.append(len(wanted))
                columns.append(column)
                values.append(weight * factor)
            wanted.append(weight * value)

        for node, k in self._index.items():
            weight = HOLD if node in self._held else STAY
            for axis in (0, 1):
                equation([(2 * k + axis, 1.0)], float(self._start[node][axis]), weight)
        for key, lane in self._lanes.items():
            i, j = (self._index[node] for node in key)
            n = (-math.sin(self._directions[key]), math.cos(self._directions[key]))
            if key in self._following:
                equation([(2 * i, n[0]), (2 * i + 1, n[1]), (2 * j, -n[0]), (2 * j + 1, -n[1])],
                         0.0, MUST)
            for fraction, sample, weight in self._samples(lane):
                f, g = 1.0 - fraction, fraction
                equation([(2 * i, f * n[0]), (2 * i + 1, f * n[1]),
                          (2 * j, g * n[0]), (2 * j + 1, g * n[1])],
                         float(sample @ n), weight)
        matrix = coo_matrix((values, (rows, columns)), (len(wanted), 2 * len(self._index))).tocsr()
        solution = spsolve((matrix.T @ matrix).tocsc(), matrix.T @ np.array(wanted))
        for node, k in self._index.items():
            self._net.positions[node] = solution[2 * k:2 * k + 2]
        for node in self._places:  # the weight only reduces a movement, but a place must not move
            self._net.positions[node] = self._start[node]

    def _samples(self, lane: Lane) -> List[Tuple[float, np.ndarray, float]]:
        """Returns points of the skeleton, each with its fraction along the lane and its weight."""
        chosen = lane.samples[np.linspace(0, len(lane.samples) - 1, SAMPLES + 2)[1:-1].astype(int)]
        a, b = (self._start[node] for node in lane.nodes)
        along = b - a
        fractions = np.clip((chosen - a) @ along / max(float(along @ along), 1e-9), 0.0, 1.0)
        room = self._net.floor.clearance_at(chosen)
        length = math.sqrt(float(along @ along))
        weights = math.sqrt(max(length, 0.2) / SAMPLES) / np.maximum(room, 0.2) ** 2
        return list(zip(fractions.tolist(), chosen, weights.tolist()))
