"""Finds each RobotHome from which a robot can reach neither a goal nor a dock."""
from __future__ import annotations

from typing import List, Optional, Sequence

import numpy as np

from omron_map.document import MapDocument
from omron_map.errors import MapWarning
from omron_map.geometry import bounds_of
from omron_map.objects import MapObject
from omron_map.occupancy import FREE, OccupancyGrid

PITCH = 25  # mm; cell size of the grid for the search
MAX_CELLS = 16_000_000  # a larger map is not searched
HALF_WIDTH = 250  # mm; half the width of the narrowest robots of the family, LD-60 and LD-90
NEARBY = 300  # mm; a robot within this distance of a place has reached it


def cut_off_homes(document: MapDocument, half_width: int = HALF_WIDTH) -> List[MapWarning]:
    """Returns a warning for each RobotHome from which a robot reaches no goal and no dock.

    half_width -- half the width of the robot, mm
    Points, lines, forbidden areas and forbidden lines are obstacles. A map without goals and docks
    causes no warnings, and neither does a map that is too large for the search.
    """
    places = document.goals + document.docks
    if not document.homes or not places:
        return []
    floor = _Floor.of(document, half_width)
    if floor is None:
        return []
    lines = {id(record.object): number for number, record in enumerate(document.records, 1)}
    return [MapWarning(f'{home} is cut off: a robot that starts there reaches no goal and no dock',
                       lines[id(home)])
            for home in document.homes if not floor.connects(home, places)]


class _Floor:
    """The cells in which a robot's centre can be."""

    def __init__(self, free: np.ndarray, origin: np.ndarray) -> None:
        self._free = free
        self._origin = origin  # position of cell (0, 0), mm

    @classmethod
    def of(cls, document: MapDocument, half_width: int) -> Optional[_Floor]:
        """Returns the floor of a map with all its obstacles; None if the map is too large."""
        seen = [document.points, document.lines,
                *(obj.outline if obj.is_area else np.array([(obj.x, obj.y)])
                  for obj in document.goals + document.docks + document.homes)]
        bounds = bounds_of(*seen)
        assert bounds is not None, 'there is at least a home'
        border = 4 * half_width  # space for a robot to drive around obstacles at the edge
        low: np.ndarray = bounds[0] - border
        high: np.ndarray = bounds[1] + border
        width, height = ((high - low) // PITCH).astype(int) + 1
        if width * height > MAX_CELLS:
            return None
        grid = OccupancyGrid(np.full((height, width), FREE, np.int8), PITCH,
                             (int(low[0]), int(low[1])))
        grid.mark(document.points)
        grid.mark_lines(document.lines)
        grid.mark_forbidden(document)
        blocked = _widened(grid.cells != FREE, half_width / PITCH)
        blocked[[0, -1], :] = blocked[:, [0, -1]] = True  # so all neighbours of free cells exist
        return cls(~blocked, low)

    def connects(self, home: MapObject, places: Sequence[MapObject]) -> bool:
        """Returns whether a robot that starts in `home` can reach one of `places`."""
        reached = self._reached_from(self._cells_at(home))
        return any(reached[self._cells_at(place)].any() for place in places)

    def _cells_at(self, obj: MapObject) -> np.ndarray:
        """Returns the flat indices of the free cells in an area or around a point."""
        corners = obj.outline if obj.is_area else np.array([(obj.x, obj.y)])
        reach = 0 if obj.is_area else NEARBY
        low = np.floor((corners.min(axis=0) - reach - self._origin) / PITCH).astype(int)
        high = np.ceil((corners.max(axis=0) + reach - self._origin) / PITCH).astype(int) + 1
        height, width = self._free.shape
        (left, bottom), (right, top) = np.maximum(low, 0), np.minimum(high, (width, height))
        rows, columns = np.nonzero(self._free[bottom:top, left:right])
        return (rows + bottom) * width + columns + left

    def _reached_from(self, start: np.ndarray) -> np.ndarray:
        """Returns for each cell whether it can be reached from `start` (flat array)."""
        unseen = self._free.ravel().copy()
        reached = np.zeros_like(unseen)
        steps = np.array((1, -1, self._free.shape[1], -self._free.shape[1]))
        wave = start
        while len(wave):
            reached[wave] = True
            unseen[wave] = False
            beside = (wave[:, None] + steps).ravel()
            wave = np.unique(beside[unseen[beside]])
        return reached


def _widened(blocked: np.ndarray, radius: float) -> np.ndarray:
    """Returns the cells within `radius` (in cells) of a blocked cell."""
    result = blocked.copy()
    height, width = blocked.shape
    row = np.zeros((height, width + 1), np.int32)
    np.cumsum(blocked, axis=1, out=row[:, 1:])
    columns = np.arange(width)
    for up in range(int(radius) + 1):
        reach = int(np.sqrt(radius ** 2 - up ** 2))
        last, first = np.minimum(columns + reach + 1, width), np.maximum(columns - reach, 0)
        near = row[:, last] > row[:, first]
        result[up:] |= near[:height - up]
        result[:height - up] |= near[up:]
    return result
