"""Finds floor that robots can reach but that is far from all edges. Updates only changed parts."""
from __future__ import annotations

import math
from functools import lru_cache
from typing import Collection, Dict, FrozenSet, Mapping, NamedTuple, Optional, Tuple

import numpy as np
from scipy import ndimage

from graph_editor.floor import EVERY_NEIGHBOUR, Floor
from graph_editor.making.coverage import Coverage, dense

KEPT = 20_000  # largest number of places with a cached part of the floor


Place = Tuple[float, float]


class Served(NamedTuple):
    """The floor that an edge serves."""

    path: np.ndarray
    cells: np.ndarray
    """(N, 2) rows and columns of the coarser grid."""


class ServedFloor:
    """The floor with a driving distance of at most `reach` m from the edges."""

    def __init__(self, floor: Floor, clearance: float, reach: float) -> None:
        """`clearance`: the free space (m) that a robot's centre needs."""
        self._floor, self._reach = floor, reach
        parts, _ = ndimage.label(floor.clearance >= clearance, EVERY_NEIGHBOUR)
        self._parts = parts
        self._part_near = lru_cache(maxsize=KEPT)(lambda place: floor.part_near(parts, place))
        self._reached: Optional[FrozenSet[int]] = None
        self._places: Dict[Place, np.ndarray] = {}
        self._paths: Dict[int, Served] = {}

    def update(self, places: Collection[Place], paths: Mapping[int, np.ndarray]) -> None:
        """Sets the vertices (`places`) and edges (`paths`, (N,2)) that serve the floor.

        A path counts as unchanged if it is the same object as at the last call.
        """
        reached = frozenset(map(self._part_near, places)) - {0}
        if reached != self._reached:
            self._reached = reached
            self.coverage = Coverage(self._floor, np.isin(self._parts, sorted(reached)),
                                     self._reach)
            self._served = np.zeros_like(self.coverage.mask)
            self._places, self._paths = {}, {}
        places_before, paths_before = self._places, self._paths
        self._places = {place: places_before[place] if place in places_before
                        else self._cells(np.array([place])) for place in places}
        self._paths = {}
        for id, path in paths.items():
            before = paths_before.get(id)
            self._paths[id] = (before if before is not None and before.path is path
                               else Served(path, self._cells(path)))
        both_ways = ((places_before, self._places), (self._places, places_before))
        changed = [cells for one, other in both_ways for place, cells in one.items()
                   if place not in other]
        for now, then in ((self._paths, paths_before), (paths_before, self._paths)):
            changed += [served.cells for id, served in now.items() if then.get(id) is not served]
        if changed:
            self._find_again(np.vstack(changed))

    def _cells(self, path: np.ndarray) -> np.ndarray:
        return np.column_stack(self.coverage.cells_of(dense(path, self.coverage.pitch)))

    def left(self) -> np.ndarray:
        """Returns the cells of the coverage's grid that are reachable and far from all edges."""
        return self.coverage.mask & ~self._served

    def _find_again(self, cells: np.ndarray) -> None:
        """Updates the served floor around changed `cells`.

        Only cells within `reach` of `cells` can change. These cells depend on the edges within
        twice this distance.
        """
        mask, border = self.coverage.mask, int(math.ceil(self._reach / self.coverage.pitch)) + 1
        low, high = cells.min(axis=0), cells.max(axis=0) + 1
        (top, left), (bottom, right) = _held(low - border, mask), _held(high + border, mask)
        outer_low, outer_high = _held(low - 2 * border, mask), _held(high + 2 * border, mask)
        starts = np.vstack([*self._places.values(), *(one.cells for one in self._paths.values())])
        starts = starts[((starts >= outer_low) & (starts < outer_high)).all(axis=1)] - outer_low
        starts = np.unique(starts, axis=0)
        window = mask[outer_low[0]:outer_high[0], outer_low[1]:outer_high[1]]
        near = self.coverage.near(window, starts)
        self._served[top:bottom, left:right] = near[top - outer_low[0]:bottom - outer_low[0],
                                                    left - outer_low[1]:right - outer_low[1]]


def _held(cell: np.ndarray, mask: np.ndarray) -> np.ndarray:
    return np.clip(cell, 0, mask.shape)
