"""The floor of a site: the free space around each place. Metres, map frame.

The floor is a grid of *clearances*. A clearance is the distance from a cell's centre to the nearest
obstacle; between centres, clearances are interpolated. If only the cells of obstacles are known,
the error is up to 0.71 of a cell; the margin of a lane covers this error. If the positions of
obstacles are known, the error is a few mm.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Iterable, Optional, Sequence, Tuple, Union

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

LARGEST_GRID = 50_000_000  # number of cells
EXACT = 1.0  # m; smaller clearances are computed from the positions of obstacles
EVERY_NEIGHBOUR = np.ones((3, 3), bool)


@dataclass(frozen=True, eq=False)
class Floor:
    """Cells of `resolution` m; row 0 has the lowest y.

    occupied  -- (rows, columns) bool: walls, furniture, forbidden areas
    inside    -- (rows, columns) bool: the part of the map that is used
    origin    -- x, y of the lower left corner of cell (0, 0)
    obstacles -- (N,2): points of obstacles and of the outlines of areas, at most one cell apart;
                 None: only cells are known
    """

    occupied: np.ndarray
    inside: np.ndarray
    resolution: float
    origin: Tuple[float, float]
    obstacles: Optional[np.ndarray] = None

    @cached_property
    def clearance(self) -> np.ndarray:
        """The distance (rows, columns; m) from each cell's centre to the nearest obstacle or edge
        of the floor.
        """
        clearance = self._distance_to(~self.inside | self.occupied)
        if self.obstacles is not None and len(self.obstacles):
            near = np.nonzero(clearance < EXACT)
            exact, _ = cKDTree(self.obstacles).query(self.centres(*near))
            exact[self.occupied[near] & (exact > self.resolution)] = 0.0  # inside an area
            clearance[near] = np.minimum(exact, self._distance_to(~self.inside)[near])
        return clearance

    def _distance_to(self, cells: np.ndarray) -> np.ndarray:
        """Returns the distance (rows, columns; m) from each cell's centre to the nearest centre of
        a cell in `cells`.
        """
        free = np.pad(~cells, 1)
        return (ndimage.distance_transform_edt(free)[1:-1, 1:-1] * self.resolution
                ).astype(np.float32)

    def of_cells(self) -> Floor:
        """Returns the floor without the exact obstacles. It is less accurate, but its walls are
        smoother.
        """
        return replace(self, obstacles=None)

    def clearance_at(self, points: np.ndarray) -> np.ndarray:
        """Returns the interpolated clearances (N,), m, at `points` (N,2); 0 outside the grid."""
        columns, rows = self._grid_coordinates(points)
        return ndimage.map_coordinates(self.clearance, (rows, columns), output=float, order=1,
                                       cval=0.0)

    def clearance_of(self, place: Union[np.ndarray, Sequence[float]]) -> float:
        """Returns the interpolated clearance, m, at one place (x, y)."""
        return float(self.clearance_at(np.array([place]))[0])

    def cells_of(self, points: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Returns rows and columns of the cells of `points` (N,2), limited to the grid."""
        columns, rows = np.rint(self._grid_coordinates(points)).astype(int)
        height, width = self.occupied.shape
        return np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)

    def centres(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Returns the centres (N,2) of cells, m."""
        return np.column_stack((self.origin[0] + (np.asarray(columns) + 0.5) * self.resolution,
                                self.origin[1] + (np.asarray(rows) + 0.5) * self.resolution))

    def reachable(self, clearance: float, starts: Iterable[Tuple[float, float]]) -> np.ndarray:
        """Returns the mask of the cells that can be reached from `starts` over cells with at least
        `clearance`.

        A start with less clearance is replaced by the nearest suitable cell within 1 m.
        """
        open_cells = self.clearance >= clearance
        parts, _ = ndimage.label(open_cells, EVERY_NEIGHBOUR)
        labels = {self.part_near(parts, start) for start in starts} - {0}
        return np.isin(parts, sorted(labels)) if labels else np.zeros_like(open_cells)

    def part_near(self, parts: np.ndarray, place: Tuple[float, float], reach: float = 1.0) -> int:
        """Returns the label in `parts` that is nearest to a place, within `reach` m; 0: none.

        parts -- (rows, columns): the label of each cell; 0: none
        """
        (row,), (column,) = self.cells_of(np.array([place]))
        (x, y), = self.centres(np.array([row]), np.array([column]))
        if math.dist((x, y), place) > reach + self.resolution:
            return 0  # off the grid
        if parts[row, column]:
            return int(parts[row, column])
        cells = int(reach / self.resolution)
        top, left = max(row - cells, 0), max(column - cells, 0)
        window = parts[top:row + cells + 1, left:column + cells + 1]
        rows, columns = np.nonzero(window)
        if not len(rows):
            return 0
        squares = (rows + top - row) ** 2 + (columns + left - column) ** 2
        nearest = int(np.argmin(squares))
        return int(window[rows[nearest], columns[nearest]]) if squares[nearest] <= cells ** 2 else 0

    def _grid_coordinates(self, points: np.ndarray) -> np.ndarray:
        return ((np.asarray(points, float) - self.origin) / self.resolution - 0.5).T


def inside_outline(occupied: np.ndarray, resolution: float, gap: float) -> np.ndarray:
    """Returns the mask of the cells inside the outline of the occupied cells.

    gap -- largest gap in the outline that counts as closed, m
    The method moves a disc of diameter `gap` around the outline: all places that the disc covers
    are outside. Everything around the grid counts as outside.
    """
    border = int(np.ceil(gap / resolution)) + 2
    padded = np.pad(occupied, border)
    room = ndimage.distance_transform_edt(~padded) * resolution
    parts, _ = ndimage.label(room >= gap / 2.0, EVERY_NEIGHBOUR)
    rolled = parts == parts[0, 0]
    swept = ndimage.distance_transform_edt(~rolled) * resolution < gap / 2.0
    return ~swept[border:-border, border:-border]
