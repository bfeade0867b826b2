"""Computes the floor that lanes serve: the floor within a given driving distance of the lanes.

Driving distances are measured on the floor, not through walls, in cells of a coarser grid.
"""
from __future__ import annotations

import math
from typing import Tuple

import numpy as np
from scipy import ndimage
from skimage.graph import MCP_Geometric

from graph_editor.floor import EVERY_NEIGHBOUR, Floor

PITCH = 0.1  # m; cell size of the coarser grid
CLOSED = -1.0  # the cost with which skimage marks a cell that cannot be passed


class Coverage:
    """The floor to be served, and its cells within `reach` m of given paths."""

    def __init__(self, floor: Floor, mask: np.ndarray, reach: float) -> None:
        """`mask`: the cells of the floor that a robot's centre can reach."""
        self._step = max(1, int(round(PITCH / floor.resolution)))
        self._floor = floor
        self.mask = mask[::self._step, ::self._step]
        """(rows, columns) bool, in the coarser grid: the cells to be served."""
        self.pitch = self._step * floor.resolution
        self._reach = reach

    @property
    def cell_area(self) -> float:
        """The area of one cell, m2."""
        return self.pitch ** 2

    def covered_by(self, path: np.ndarray) -> np.ndarray:
        """Returns the cells that the path (M,2) serves, as indices (N,) in the flat mask."""
        rows, columns = self.cells_of(dense(path, self.pitch))
        border = int(math.ceil(self._reach / self.pitch)) + 1
        top, left = max(rows.min() - border, 0), max(columns.min() - border, 0)
        window = self.mask[top:rows.max() + border + 1, left:columns.max() + border + 1]
        starts = np.unique(np.column_stack((rows - top, columns - left)), axis=0)
        ways = self._ways(window, starts)
        inside = np.nonzero(ways * self.pitch <= self._reach)
        return (inside[0] + top) * self.mask.shape[1] + inside[1] + left

    def distances(self, path: np.ndarray) -> np.ndarray:
        """Returns the driving distance (m) from each cell to the nearest point of `path` (N,2)."""
        rows, columns = self.cells_of(path)
        starts = np.unique(np.column_stack((rows, columns)), axis=0)
        return np.where(self.mask, self._ways(self.mask, starts) * self.pitch, np.inf)

    def left_without(self, servants: np.ndarray, served: np.ndarray) -> float:
        """Returns the area (m2) that would be unserved if one path were removed.

        Adjacent cells that are already unserved also count. Otherwise a short dead end would seem
        less useful than a long one, and dead ends would be removed bit by bit.

        servants -- number of paths that serve each cell of the flat mask
        served   -- the cells that the path serves
        """
        alone = served[servants[served] == 1]
        unserved = self.mask & (servants == 0).reshape(self.mask.shape)
        unserved.flat[alone] = True
        parts, _ = ndimage.label(unserved, EVERY_NEIGHBOUR)
        there = np.unique(parts.flat[alone])
        return float(np.isin(parts, there[there > 0]).sum()) * self.cell_area

    def near(self, window: np.ndarray, starts: np.ndarray) -> np.ndarray:
        """Returns which cells of a `window` of the mask are within reach of `starts` (N,2)."""
        if not len(starts):
            return np.zeros_like(window)
        return self._ways(window, starts) * self.pitch <= self._reach

    def cells_of(self, points: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Returns the rows and columns, in the coarser grid, of the cells of points (N,2)."""
        rows, columns = self._floor.cells_of(points)
        height, width = self.mask.shape
        return (np.minimum(rows // self._step, height - 1),
                np.minimum(columns // self._step, width - 1))

    def points_of(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Returns the points (N,2; m) that represent cells of the coarser grid."""
        return self._floor.centres(rows * self._step, columns * self._step)

    @staticmethod
    def _ways(window: np.ndarray, starts: np.ndarray) -> np.ndarray:
        costs = np.where(window, 1.0, CLOSED)
        costs[starts[:, 0], starts[:, 1]] = 1.0  # a lane may touch a cell outside the floor
        ways, _ = MCP_Geometric(costs).find_costs(starts)
        return np.where(window, ways, np.inf)


def dense(path: np.ndarray, step: float) -> np.ndarray:
    """Returns the path (N,2) with points at most `step` m apart."""
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    arc = np.concatenate(([0.0], np.cumsum(lengths)))
    if len(path) == 1:
        return path
    count = max(2, int(math.ceil(arc[-1] / step)) + 1)
    s = np.linspace(0.0, arc[-1], count)
    return np.column_stack((np.interp(s, arc, path[:, 0]), np.interp(s, arc, path[:, 1])))
