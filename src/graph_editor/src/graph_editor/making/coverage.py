"""What the lanes serve: the floor that a robot reaches from them within a given way.

Ways lead over the floor and not through walls. Counted in cells of a coarser grid.
"""
from __future__ import annotations

import math
from typing import Tuple

import numpy as np
from scipy import ndimage
from skimage.graph import MCP_Geometric

from graph_editor.floor import EVERY_NEIGHBOUR, Floor

PITCH = 0.1  # m, of the coarser grid
CLOSED = -1.0  # what skimage takes for a cell that no way leads through


class Coverage:
    """The floor in question, and which of its cells lie within `reach` m of given paths."""

    def __init__(self, floor: Floor, mask: np.ndarray, reach: float) -> None:
        """`mask`: the cells of the floor that a robot's centre can reach."""
        self._step = max(1, int(round(PITCH / floor.resolution)))
        self._floor = floor
        self.mask = mask[::self._step, ::self._step]
        """(rows, columns) bool, coarser: what shall be covered."""
        self.pitch = self._step * floor.resolution
        self._reach = reach

    @property
    def cell_area(self) -> float:
        """m2 of one cell."""
        return self.pitch ** 2

    def covered_by(self, path: np.ndarray) -> np.ndarray:
        """Indices (N,) into the flat mask of the cells that the path (M,2) serves."""
        rows, columns = self.cells_of(dense(path, self.pitch))
        border = int(math.ceil(self._reach / self.pitch)) + 1
        top, left = max(rows.min() - border, 0), max(columns.min() - border, 0)
        window = self.mask[top:rows.max() + border + 1, left:columns.max() + border + 1]
        starts = np.unique(np.column_stack((rows - top, columns - left)), axis=0)
        ways = self._ways(window, starts)
        inside = np.nonzero(ways * self.pitch <= self._reach)
        return (inside[0] + top) * self.mask.shape[1] + inside[1] + left

    def distances(self, path: np.ndarray) -> np.ndarray:
        """(rows, columns) m: the way from each cell to the nearest of the points `path` (N,2)."""
        rows, columns = self.cells_of(path)
        starts = np.unique(np.column_stack((rows, columns)), axis=0)
        return np.where(self.mask, self._ways(self.mask, starts) * self.pitch, np.inf)

    def left_without(self, servants: np.ndarray, served: np.ndarray) -> float:
        """How large (m2) the floor would be that nothing serves, where only one path serves it.

        `servants`: how many paths serve each cell of the flat mask; `served`: the path's cells.
        What is out of reach already and adjoins counts, too: else a dead end, the shorter it is,
        the less it seems to be good for, and is taken off bit by bit.
        """
        alone = served[servants[served] == 1]
        unserved = self.mask & (servants == 0).reshape(self.mask.shape)
        unserved.flat[alone] = True
        parts, _ = ndimage.label(unserved, EVERY_NEIGHBOUR)
        there = np.unique(parts.flat[alone])
        return float(np.isin(parts, there[there > 0]).sum()) * self.cell_area

    def near(self, window: np.ndarray, starts: np.ndarray) -> np.ndarray:
        """Which cells of a `window` of the mask lie within the reach of cells `starts` (N,2)."""
        if not len(starts):
            return np.zeros_like(window)
        return self._ways(window, starts) * self.pitch <= self._reach

    def cells_of(self, points: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the coarser cells that hold points (N,2)."""
        rows, columns = self._floor.cells_of(points)
        height, width = self.mask.shape
        return (np.minimum(rows // self._step, height - 1),
                np.minimum(columns // self._step, width - 1))

    def points_of(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """(N,2) m: the places that coarser cells stand for."""
        return self._floor.centres(rows * self._step, columns * self._step)

    @staticmethod
    def _ways(window: np.ndarray, starts: np.ndarray) -> np.ndarray:
        costs = np.where(window, 1.0, CLOSED)
        costs[starts[:, 0], starts[:, 1]] = 1.0  # a lane may touch a cell beside the floor
        ways, _ = MCP_Geometric(costs).find_costs(starts)
        return np.where(window, ways, np.inf)


def dense(path: np.ndarray, step: float) -> np.ndarray:
    """The path (N,2) with points at most `step` m apart."""
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    arc = np.concatenate(([0.0], np.cumsum(lengths)))
    if len(path) == 1:
        return path
    count = max(2, int(math.ceil(arc[-1] / step)) + 1)
    s = np.linspace(0.0, arc[-1], count)
    return np.column_stack((np.interp(s, arc, path[:, 0]), np.interp(s, arc, path[:, 1])))
