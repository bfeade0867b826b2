"""The floor of the robot: the distance of each place from walls and forbidden areas.

There are two fields on a grid with the map's own pitch: `clearance`, the distance to anything that
the robot may not touch, and `sight`, the distance to anything that its laser sees. The centres of
the cells are multiples of the pitch, like the scan points, so that scan points are not rounded. A
floor never changes; all robots on a map share it. Fields that only some robots need are computed on
first use.
"""
from __future__ import annotations

import math
from functools import cached_property
from typing import Iterable, Tuple

import numpy as np
from scipy import ndimage

from omron_ld90_sim.motion.kinematics import LD90_BODY, Body
from omron_map import MapDocument

DEFAULT_RESOLUTION = 20
MAX_CELLS = 6_000_000
MARGIN = 1000           # mm of floor around a goal or dock outside the walls
EXACT_DISTANCE = 750    # mm around lines and areas in which clearance is exact; enough to plan
PLANNING_PITCH = 60     # mm, cell size of the planner's grid


class SimFloor:
    """Distance fields of one map; all lengths in mm, map frame."""

    def __init__(self, points: np.ndarray, segments: np.ndarray, forbidden_segments: np.ndarray,
                 areas: Iterable[np.ndarray], resolution: int, places: np.ndarray,
                 body: Body = LD90_BODY) -> None:
        """`areas` are (4, 2) corners; `places` are further points that the grid must contain."""
        self.body = body
        areas = [np.asarray(area, float) for area in areas]
        self._lay_out(points, segments, places, resolution)
        self._points, self._segments = points, segments
        occupied = np.zeros(self.shape, bool)
        self._mark(occupied, points)
        self.clearance = self._distance(~occupied)
        for segment in np.concatenate([segments, forbidden_segments]):
            self._keep_away(segment.reshape(2, 2), inside=False)
        for corners in areas:
            self._keep_away(corners, inside=True)
        self._keep_off_the_edge()
        step = max(1, int(round(PLANNING_PITCH / self.resolution)))
        self.planning_clearance = np.ascontiguousarray(self.clearance[::step, ::step])
        self.planning_pitch = step * self.resolution

    @cached_property
    def sight(self) -> np.ndarray:
        """Distance (mm) from every cell to the nearest point or line that the laser sees."""
        seen = np.zeros(self.shape, bool)
        self._mark(seen, self._points)
        for x1, y1, x2, y2 in self._segments:
            count = int(math.hypot(x2 - x1, y2 - y1) / (self.resolution / 2)) + 2
            self._mark(seen, np.column_stack([np.linspace(x1, x2, count),
                                              np.linspace(y1, y2, count)]))
        return self._distance(~seen)

    @cached_property
    def regions(self) -> np.ndarray:
        """The number (from 1) of each planning cell's connected region; 0: no room to turn."""
        room = self.planning_clearance >= self.body.half_diagonal
        return ndimage.label(room, structure=np.ones((3, 3)))[0]

    @classmethod
    def from_map(cls, document: MapDocument) -> SimFloor:
        """Returns the floor of a `.map` file."""
        extents = [line.extent for line in document.forbidden_lines if line.extent is not None]
        lines = [[e.from_x, e.from_y, e.to_x, e.to_y] for e in extents]
        places = [[o.x, o.y] for o in (*document.goals, *document.docks)]
        return cls(np.asarray(document.points, float).reshape(-1, 2),
                   np.asarray(document.lines, float).reshape(-1, 4),
                   np.asarray(lines, float).reshape(-1, 4),
                   [area.rectangle.corners for area in document.forbidden_areas],
                   document.resolution or DEFAULT_RESOLUTION,
                   np.asarray(places, float).reshape(-1, 2))

    def _lay_out(self, points: np.ndarray, segments: np.ndarray, places: np.ndarray,
                 resolution: int) -> None:
        everything = np.concatenate([points, segments.reshape(-1, 2), places - MARGIN,
                                     places + MARGIN])
        if not len(everything):
            everything = np.array([[-5000.0, -5000.0], [5000.0, 5000.0]])
        low, high = everything.min(axis=0), everything.max(axis=0)
        while np.prod((high - low) / resolution + 2) > MAX_CELLS:
            resolution *= 2
        self.resolution = float(resolution)
        first = np.floor(low / resolution).astype(int)
        last = np.ceil(high / resolution).astype(int)
        self.origin = first * self.resolution       # centre of cell [0, 0] (x, y)
        self.shape: Tuple[int, int] = (int(last[1] - first[1]) + 1, int(last[0] - first[0]) + 1)

    def _mark(self, cells: np.ndarray, points: np.ndarray) -> None:
        index = np.rint((points - self.origin) / self.resolution).astype(int)
        cells[index[:, 1], index[:, 0]] = True

    def _distance(self, free: np.ndarray) -> np.ndarray:
        if free.all():
            return np.full(self.shape, 1e6, np.float32)
        return (ndimage.distance_transform_edt(free) * self.resolution).astype(np.float32)

    def _keep_away(self, corners: np.ndarray, inside: bool) -> None:
        """Lowers the clearance around a segment (2 corners) or a polygon, with exact values."""
        low = np.floor((corners.min(axis=0) - EXACT_DISTANCE - self.origin) / self.resolution)
        high = np.ceil((corners.max(axis=0) + EXACT_DISTANCE - self.origin) / self.resolution)
        c0, r0 = np.maximum(low, 0).astype(int)
        c1, r1 = np.minimum(high + 1, [self.shape[1], self.shape[0]]).astype(int)
        if c0 >= c1 or r0 >= r1:
            return
        x = self.origin[0] + np.arange(c0, c1) * self.resolution
        y = (self.origin[1] + np.arange(r0, r1) * self.resolution)[:, None]
        squares, within = np.array(np.inf), np.array(True)
        sides = zip(corners, np.roll(corners, -1, axis=0)) if len(corners) > 2 else [corners]
        for (ax, ay), (bx, by) in sides:
            length = math.hypot(bx - ax, by - ay)
            dx, dy = ((bx - ax) / length, (by - ay) / length) if length else (1.0, 0.0)
            beside = (y - ay) * dx - (x - ax) * dy
            beyond = (x - ax) * dx + (y - ay) * dy
            beyond -= np.minimum(np.maximum(beyond, 0.0), length)
            if inside:
                within = within & (beside >= 0)
            squares = np.minimum(squares, beside * beside + beyond * beyond)
        distance = np.sqrt(squares)
        if inside:
            distance[within] = 0.0
        window = self.clearance[r0:r1, c0:c1]
        np.minimum(window, distance, out=window, casting='unsafe')

    def _keep_off_the_edge(self) -> None:
        rows = np.arange(self.shape[0])
        columns = np.arange(self.shape[1])
        to_row = np.minimum(rows, rows[::-1])[:, None] * self.resolution
        to_column = np.minimum(columns, columns[::-1])[None, :] * self.resolution
        np.minimum(self.clearance, np.minimum(to_row, to_column), out=self.clearance,
                   casting='unsafe')

    @property
    def end(self) -> np.ndarray:
        """The centre of the last cell (x, y)."""
        return self.origin + (np.array(self.shape[::-1]) - 1) * self.resolution

    def holds(self, x: float, y: float) -> bool:
        """Returns whether a point is on the map."""
        return bool(self.origin[0] <= x <= self.end[0] and self.origin[1] <= y <= self.end[1])

    def clearance_at(self, xy: np.ndarray) -> np.ndarray:
        """Returns the distance (mm) from each point (N, 2) to an obstacle; 0 outside the map.

        The distance is interpolated between cells. It is exact within a few mm, except that it is
        too small midway between obstacles.
        """
        position = (np.asarray(xy, float).reshape(-1, 2) - self.origin) / self.resolution
        column, row = position[:, 0], position[:, 1]
        c = np.clip(np.floor(column).astype(int), 0, self.shape[1] - 2)
        r = np.clip(np.floor(row).astype(int), 0, self.shape[0] - 2)
        u, v = np.clip(column - c, 0, 1), np.clip(row - r, 0, 1)
        field = self.clearance
        return ((field[r, c] * (1 - u) + field[r, c + 1] * u) * (1 - v)
                + (field[r + 1, c] * (1 - u) + field[r + 1, c + 1] * u) * v)

    def clearance_of(self, x: float, y: float) -> float:
        """Returns the clearance of one point."""
        return float(self.clearance_at(np.array([[x, y]]))[0])

    def planning_cell(self, x: float, y: float) -> Tuple[int, int]:
        """Returns the row and column of the planner's grid nearest to a point."""
        # int(): before numpy 1.19, round() of a numpy float returns a float
        column = int(round((x - self.origin[0]) / self.planning_pitch))
        row = int(round((y - self.origin[1]) / self.planning_pitch))
        rows, columns = self.planning_clearance.shape
        return min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)

    def planning_points(self, cells: np.ndarray) -> np.ndarray:
        """Returns points (N, 2) of planning cells that are given as (row, column)."""
        return self.origin + np.asarray(cells)[:, ::-1] * self.planning_pitch
