"""Finds places for texts beside their points, so that no text covers another.

A text gets the first of its places that is free. If no place is free, the text gets the place at
which it covers least, provided that `may` allows this: a text may cover nothing, soft boxes or all
boxes. The editor and RViz use this module. The page has the same rules in `placing.js`, and a test
in `fleet_page` compares the two.
"""
from __future__ import annotations

import math
from enum import Enum
from itertools import product
from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

Box = Tuple[float, float, float, float]  # left, lower, right, upper
Side = Tuple[int, int]                   # (x, y): 1, -1: on this side of the point; 0: centred
_Cell = Tuple[int, int]

ABOVE_FIRST: Tuple[Side, ...] = (
    (0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))
"""The sides of a point, the best one first; y upwards."""
BELOW_RIGHT_FIRST: Tuple[Side, ...] = (
    (1, -1), (-1, -1), (1, 1), (-1, 1), (0, -1), (0, 1), (1, 0), (-1, 0))
"""The sides of a vertex, the best one first: the corners, because edges are at the sides."""
CELL = 1.6  # m, cell size of the grid in which near boxes are searched


class MayCover(Enum):
    """What a text may cover if none of its places is free.

    A soft box may be covered if necessary; all other boxes are firm.
    """

    NOTHING = 'nothing'
    SOFT = 'soft boxes'
    ALL = 'all'


class Covered(NamedTuple):
    """The area of a box that firm boxes cover, and the area that soft boxes cover."""

    firm: float = 0.0
    soft: float = 0.0


class _Cover:
    """A covered box. Two covered boxes at the same place are different objects."""

    def __init__(self, box: Box, is_soft: bool, weight: float) -> None:
        self.box, self.is_soft, self.weight = box, is_soft, weight


class Places:
    """The boxes that are covered.

    window  -- places outside this box count as covered by firm boxes; None: there is no window
    cell    -- cell size of the grid in which near boxes are searched
    beneath -- further covered boxes, which do not change from picture to picture
    """

    def __init__(self, window: Optional[Box] = None, cell: float = CELL,
                 beneath: Optional[Places] = None) -> None:
        self._window, self._cell, self._beneath = window, cell, beneath
        self._cells: Dict[_Cell, List[_Cover]] = {}

    def cover(self, box: Box, is_soft: bool = False, weight: float = 1.0) -> None:
        """Marks a box as covered. `weight`: factor of its area."""
        cover = _Cover(box, is_soft, weight)
        for cell in self._cells_of(box):
            self._cells.setdefault(cell, []).append(cover)

    def uncover(self, box: Box) -> None:
        """Reverts the first call of `cover` with this box."""
        for one in [one for cell in self._cells_of(box) for one in self._cells.get(cell, ())
                    if one.box == box][:1]:
            for cell in self._cells_of(box):
                self._cells[cell].remove(one)

    def place(self, boxes: Sequence[Box], before: int = -1,
              may: MayCover = MayCover.NOTHING) -> int:
        """Covers the best of `boxes` with a text. Returns its number; -1: the text has no place.

        before -- number of the former box of the text; the text stays there while this box is free
        """
        numbers = range(len(boxes))
        best, least = -1, Covered(math.inf, math.inf)
        for number in numbers if before < 0 else (
                before, *(one for one in numbers if one != before)):
            covered = self.covered(boxes[number])
            if covered < least:
                best, least = number, covered
            if not any(covered):
                break
        if (least.firm and may is not MayCover.ALL) or (least.soft and may is MayCover.NOTHING):
            return -1
        self.cover(boxes[best])
        return best

    def covered(self, box: Box) -> Covered:
        """Returns how much of a box is covered."""
        firm, soft = self._beneath.covered(box) if self._beneath else Covered()
        if self._window is not None:
            firm += (box[2] - box[0]) * (box[3] - box[1]) - shared(box, self._window)
        seen = set()
        for cell in self._cells_of(box):
            for one in self._cells.get(cell, ()):
                if one in seen:
                    continue
                seen.add(one)
                if one.is_soft:
                    soft += one.weight * shared(box, one.box)
                else:
                    firm += one.weight * shared(box, one.box)
        return Covered(firm, soft)

    def _cells_of(self, box: Box) -> Iterator[_Cell]:
        left, lower, right, upper = (math.floor(side / self._cell) for side in box)
        return product(range(left, right + 1), range(lower, upper + 1))


def shared(one: Box, other: Box) -> float:
    """Returns the area that two boxes share."""
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    return width * height if width > 0.0 and height > 0.0 else 0.0


def box_around(middle: Tuple[float, float], size: Tuple[float, float]) -> Box:
    """Returns the box of this size around a point."""
    (x, y), (width, height) = middle, size
    return x - width / 2.0, y - height / 2.0, x + width / 2.0, y + height / 2.0


def middle_of(box: Box) -> Tuple[float, float]:
    """Returns the middle of a box."""
    return (box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0


def box_beside(point: Tuple[float, float], away: float, size: Tuple[float, float],
               side: Side) -> Box:
    """Returns the box of a text of this size on one side of a point, `away` from it."""
    (x, y), (right, up) = point, side
    away *= math.sqrt(0.5) if right and up else 1.0
    return box_around((x + right * (away + size[0] / 2.0), y + up * (away + size[1] / 2.0)), size)
