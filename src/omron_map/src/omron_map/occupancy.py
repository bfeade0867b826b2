"""Occupancy grid of a map, for navigation software and RViz.

A file has only the occupied places. The caller decides whether the rest is unknown or free. The
lower left corner of cell (0, 0) is at the lowest x and y of all rows, as in published maps.
Strictly, scan points are the centres of cells, so the grid is half a cell too far to the upper
right. Bounds are inclusive, and come from the rows, not from the header.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from omron_map.document import MapDocument
from omron_map.errors import MapError
from omron_map.objects import MapObject
from omron_map.sections import bounds

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
MAX_CELLS = 100_000_000
USES = ('auto', 'points', 'lines', 'both')


@dataclass(frozen=True)
class OccupancyGrid:
    """An occupancy grid.

    cells      -- `cells[row, column]`, int8; row 0 is at the lowest y
    resolution -- size of a cell, mm
    origin     -- x, y of the lower left corner of cell (0, 0), mm
    """

    cells: np.ndarray
    resolution: int
    origin: Tuple[int, int]

    @classmethod
    def from_map(cls, document: MapDocument, resolution: Optional[int] = None,
                 use: str = 'auto', areas: bool = False, background: int = UNKNOWN
                 ) -> OccupancyGrid:
        """Returns the grid of `document`.

        resolution -- size of a cell, mm; None: the map's own pitch
        use        -- `points`, `lines`, `both`, or `auto`: points if there are any, else lines
        areas      -- whether forbidden areas and lines inside the grid are occupied, too
        background -- value of all other cells
        Raises MapError if there is no pitch, if there are no rows, or if the grid is too large.
        """
        pitch = resolution if resolution is not None else document.resolution
        if pitch is None or pitch <= 0:
            raise MapError(document.name, 'it gives no pitch for a grid', field='Resolution',
                           expected='a given resolution in mm')
        points, lines = _rows(document, use)
        ends = np.concatenate((points, lines.reshape(-1, 2)))
        if not len(ends):
            raise MapError(document.name, 'there are no points and no lines for a grid')
        low, high = bounds(ends)
        width, height = _size(low, high, pitch)
        if width * height > MAX_CELLS:
            raise MapError(document.name, f'a grid of {width} x {height} cells is too large',
                           field='resolution', expected=f'at most {MAX_CELLS} cells')
        cells = np.full((height, width), background, np.int8)
        grid = cls(cells, pitch, low)
        grid.mark(points)
        grid.mark_lines(lines)
        if areas:
            grid.mark_forbidden(document)
        return grid

    @property
    def width(self) -> int:
        """Number of columns."""
        return self.cells.shape[1]

    @property
    def height(self) -> int:
        """Number of rows."""
        return self.cells.shape[0]

    def mark(self, points: np.ndarray) -> None:
        """Occupies the cells of `points` (N, 2), mm; points outside the grid are ignored."""
        columns, rows = ((points - self.origin) // self.resolution).astype(np.int32).T
        inside = (columns >= 0) & (columns < self.width) & (rows >= 0) & (rows < self.height)
        self.cells[rows[inside], columns[inside]] = OCCUPIED

    def mark_lines(self, lines: np.ndarray) -> None:
        """Occupies the cells along each line, in steps of less than half a cell."""
        for line in lines.astype(float):
            start, end = line[:2], line[2:]
            steps = int(np.abs(end - start).max() * 2 / self.resolution) + 1
            self.mark(start + np.linspace(0.0, 1.0, steps + 1)[:, None] * (end - start))

    def mark_forbidden(self, document: MapDocument) -> None:
        """Occupies the cells of forbidden areas and forbidden lines, clipped to the grid."""
        for area in document.forbidden_areas:
            self._mark_area(area)
        for line in document.forbidden_lines:
            self.mark_lines(line.ends.reshape(1, 4))

    def _mark_area(self, area: MapObject) -> None:
        """Occupies the cells with centres in the area's rectangle, including its edges."""
        rectangle = area.rectangle
        low = (rectangle.corners.min(axis=0) - self.origin) // self.resolution
        high = (rectangle.corners.max(axis=0) - self.origin) // self.resolution + 1
        left, bottom = np.maximum(low, 0).astype(int)
        right, top = np.minimum(high, (self.width, self.height)).astype(int)
        if left >= right or bottom >= top:
            return
        xs = self.origin[0] + (np.arange(left, right) + 0.5) * self.resolution
        ys = self.origin[1] + (np.arange(bottom, top) + 0.5) * self.resolution
        centres = np.stack(np.meshgrid(xs, ys), axis=-1)
        self.cells[bottom:top, left:right][rectangle.contains(centres)] = OCCUPIED


def fitting_resolution(document: MapDocument, resolution: int) -> int:
    """Returns `resolution` (mm), or its smallest multiple for which the grid is not too large."""
    ends = np.concatenate((document.points, document.lines.reshape(-1, 2)))
    low, high = bounds(ends) if len(ends) else ((0, 0), (0, 0))
    pitch = resolution
    width, height = _size(low, high, pitch)
    while width * height > MAX_CELLS:
        pitch += resolution
        width, height = _size(low, high, pitch)
    return pitch


def _size(low: Tuple[int, int], high: Tuple[int, int], pitch: int) -> Tuple[int, int]:
    """Returns width and height in cells; the bounds are inclusive."""
    return (high[0] - low[0]) // pitch + 1, (high[1] - low[1]) // pitch + 1


def _rows(document: MapDocument, use: str) -> Tuple[np.ndarray, np.ndarray]:
    """Returns the points and lines to draw."""
    if use not in USES:
        raise ValueError(f'use is {use!r}, but must be one of {", ".join(USES)}')
    points, lines = document.points, document.lines
    if use == 'lines' or (use == 'auto' and not len(points)):
        points = points[:0]
    if use == 'points' or (use == 'auto' and len(points)):
        lines = lines[:0]
    return points, lines
