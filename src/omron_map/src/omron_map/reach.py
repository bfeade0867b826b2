"""Which places of a map a robot can get to from another: is a RobotHome cut off from all goals?"""
from __future__ import annotations

from typing import List, Optional, Sequence

import numpy as np

from omron_map.document import MapDocument
from omron_map.errors import MapWarning
from omron_map.geometry import bounds_of
from omron_map.objects import MapObject
from omron_map.occupancy import FREE, OccupancyGrid

PITCH = 25  # mm, of the grid that is searched
MAX_CELLS = 16_000_000  # a larger map is not judged
HALF_WIDTH = 250  # mm, of the narrowest robot of the family, the LD-60 and LD-90
NEARBY = 300  # mm around a place in which the robot counts as there


def cut_off_homes(document: MapDocument, half_width: int = HALF_WIDTH) -> List[MapWarning]:
    """A warning for each RobotHome from which a robot so wide (mm) gets to no goal and no dock.

    Points, lines, forbidden areas and forbidden lines are in its way. Nothing is said of a map
    without goals and docks, or one that is too large to be searched.
    """
    places = document.goals + document.docks
    if not document.homes or not places:
        return []
    floor = _Floor.of(document, half_width)
    if floor is None:
        return []
    lines = {id(record.object): number for number, record in enumerate(document.records, 1)}
    return [MapWarning(f'{home} is cut off: a robot that starts there gets to no goal and no dock',
                       lines[id(home)])
            for home in document.homes if not floor.connects(home, places)]


class _Floor:
    """The cells where a robot's centre can be."""

    def __init__(self, free: np.ndarray, origin: np.ndarray) -> None:
        self._free = free
        self._origin = origin  # mm, of cell (0, 0)

    @classmethod
    def of(cls, document: MapDocument, half_width: int) -> Optional[_Floor]:
        """The floor of all that stands in the map; None where it is too large."""
        seen = [document.points, document.lines,
                *(obj.outline if obj.is_area else np.array([(obj.x, obj.y)])
                  for obj in document.goals + document.docks + document.homes)]
        bounds = bounds_of(*seen)
        assert bounds is not None, 'there is at least a home'
        border = 4 * half_width  # a robot may drive around what stands at the edge
        low, high = bounds[0] - border, bounds[1] + border
        width, height = ((high - low) // PITCH).astype(int) + 1
        if width * height > MAX_CELLS:
            return None
        grid = OccupancyGrid(np.full((height, width), FREE, np.int8), PITCH,
                             (int(low[0]), int(low[1])))
        grid.mark(document.points)
        grid.mark_lines(document.lines)
        grid.mark_forbidden(document)
        blocked = _widened(grid.cells != FREE, half_width / PITCH)
        blocked[[0, -1], :] = blocked[:, [0, -1]] = True  # so that no neighbour is outside
        return cls(~blocked, low)

    def connects(self, home: MapObject, places: Sequence[MapObject]) -> bool:
        """Can a robot that starts in `home` get to any of `places`?"""
        reached = self._reached_from(self._cells_at(home))
        return any(reached[self._cells_at(place)].any() for place in places)

    def _cells_at(self, obj: MapObject) -> np.ndarray:
        """Flat indices of the free cells in an area, or around a point."""
        corners = obj.outline if obj.is_area else np.array([(obj.x, obj.y)])
        reach = 0 if obj.is_area else NEARBY
        low = np.floor((corners.min(axis=0) - reach - self._origin) / PITCH).astype(int)
        high = np.ceil((corners.max(axis=0) + reach - self._origin) / PITCH).astype(int) + 1
        height, width = self._free.shape
        (left, bottom), (right, top) = np.maximum(low, 0), np.minimum(high, (width, height))
        rows, columns = np.nonzero(self._free[bottom:top, left:right])
        return (rows + bottom) * width + columns + left

    def _reached_from(self, start: np.ndarray) -> np.ndarray:
        """Which cells can be reached, flat: a wave that runs from cell to cell."""
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
    """The cells nearer than `radius` (in cells) to a blocked one."""
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
