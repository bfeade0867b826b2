"""Floor plans for tests (rooms with doors, halls, objects), as sites that need no file."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Tuple

import numpy as np
from hypothesis import strategies as st

from graph_editor.floor import Floor
from graph_editor.site import MappedSite, NamedPlace, PlaceKind

RESOLUTION = 0.05
Box = Tuple[float, float, float, float]  # x1, y1, x2, y2 in m


@dataclass(frozen=True)
class Plan:
    """Walls and objects as boxes (m), the start of robots, and named places."""

    width: float
    height: float
    boxes: Tuple[Box, ...]
    start: Tuple[float, float]
    places: Tuple[NamedPlace, ...] = ()

    def site(self, name: str = 'plan') -> MappedSite:
        """Returns a site of the plan with outer walls around it."""
        rows, columns = (int(round(side / RESOLUTION)) + 4 for side in (self.height, self.width))
        occupied = np.zeros((rows, columns), bool)
        occupied[:2], occupied[-2:], occupied[:, :2], occupied[:, -2:] = True, True, True, True
        for x1, y1, x2, y2 in self.boxes:
            left, bottom, right, top = (max(int(round(value / RESOLUTION)) + 2, 0)
                                        for value in (x1, y1, x2, y2))
            occupied[bottom:max(top, bottom + 1), left:max(right, left + 1)] = True
        floor = Floor(occupied, np.ones_like(occupied), RESOLUTION,
                      (-2 * RESOLUTION, -2 * RESOLUTION))
        home = NamedPlace(PlaceKind.HOME, '', *self.start)
        return MappedSite(name, floor, (home, *self.places))


def corridor(length: float = 12.0, width: float = 2.4) -> Plan:
    """Returns a straight corridor."""
    return Plan(length, width, (), (1.0, width / 2.0))


def two_rooms(door: float = 1.4) -> Plan:
    """Returns two rooms of 6 x 5 m, one above the other, joined by a door in the middle."""
    left, right = 3.0 - door / 2.0, 3.0 + door / 2.0
    return Plan(6.0, 10.1, ((0.0, 5.0, left, 5.1), (right, 5.0, 6.0, 5.1)), (3.0, 2.5))


def corner() -> Plan:
    """Returns a corridor 2 m wide with a right-angled corner."""
    return Plan(10.0, 10.0, ((2.0, 0.0, 10.0, 8.0),), (1.0, 1.0))


@st.composite
def floor_plans(draw: st.DrawFn) -> Plan:
    """Draws a corridor between two rows of rooms with doors. The plan has random objects, and
    sometimes a hall at the end.
    """
    passage = draw(st.sampled_from((1.3, 1.8, 2.6)))
    depths = draw(st.integers(28, 60)) / 10.0, draw(st.integers(28, 60)) / 10.0
    widths = draw(st.lists(st.integers(26, 60).map(lambda cm: cm / 10.0), min_size=1, max_size=3))
    hall = draw(st.sampled_from((0.0, 0.0, 7.0)))
    length, height = sum(widths) + hall, depths[0] + passage + depths[1]
    boxes: List[Box] = []
    for row, y in enumerate((depths[0], depths[0] + passage)):
        x = 0.0
        for width in widths:
            door = draw(st.sampled_from((0.0, 0.7, 1.0, 1.6)))
            where = x + 0.3 + draw(st.integers(0, 10)) / 10.0 * (width - 0.6 - door)
            boxes += [(x, y - 0.05, where, y + 0.05), (where + door, y - 0.05, x + width, y + 0.05)]
            if x:
                bottom, top = ((0.0, depths[0]), (height - depths[1], height))[row]
                boxes.append((x - 0.05, bottom, x + 0.05, top))
            x += width
        if hall:
            boxes.append((x - 0.05, (0.0, y)[row], x + 0.05, (depths[0], height)[row]))
    for _ in range(draw(st.integers(0, 6))):
        x, y = draw(st.integers(0, 99)) / 100.0 * length, draw(st.integers(0, 99)) / 100.0 * height
        side = draw(st.sampled_from((0.05, 0.4, 1.2)))
        boxes.append((x, y, x + side, y + side * draw(st.sampled_from((1.0, 2.0)))))
    start = (length - 0.8 if hall else 0.9, depths[0] + passage / 2.0)
    boxes = [box for box in boxes if not (box[0] - 1.0 < start[0] < box[2] + 1.0
                                          and box[1] - 0.4 < start[1] < box[3] + 0.4)]
    return Plan(length, height, tuple(boxes), start)
