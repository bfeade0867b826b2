"""Chooses where the label of each robot is drawn, so that labels stay readable when robots meet.

A label keeps its side while this side is free. If no side is free, it covers edges if possible,
otherwise names and rings of vertices and stations. It covers other labels and robots only as a last
choice (`placing`).
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterable, List, Mapping, Optional, Tuple

from rviz_drawing.text_places import text_size
from trajectory_graph.placing import (
    ABOVE_FIRST,
    Box,
    MayCover,
    Places,
    box_around,
    box_beside,
    middle_of,
)

GAP = 0.12  # m between a robot and its label
NAME_WEIGHT = 10.0  # weight of names: a text on a text is harder to read than a text on a line


@dataclass(frozen=True)
class Label:
    """The label of a robot: the robot's position and radius (m), the text and its height (m)."""

    x: float
    y: float
    radius: float
    words: str
    height: float

    @property
    def size(self) -> Tuple[float, float]:
        """The approximate width and height of the text, in m."""
        return text_size(self.words, self.height)

    def boxes(self) -> List[Box]:
        """Returns the places of the text, one for each of ABOVE_FIRST."""
        size = self.size
        return [box_beside((self.x, self.y), self.radius + GAP, size, side)
                for side in ABOVE_FIRST]

    def middle(self, side: int) -> Tuple[float, float]:
        """Returns the centre of the text (m) if the text is on this side, an index in ABOVE_FIRST.
        """
        return middle_of(self.boxes()[side])


class LabelPlaces:
    """Remembers for each robot the side on which its label is drawn."""

    def __init__(self) -> None:
        self._sides: Dict[str, int] = {}

    def side(self, name: str) -> int:
        """Returns the index in ABOVE_FIRST for this robot's label."""
        return self._sides.get(name, 0)

    def choose(self, labels: Mapping[str, Label], window: Optional[Box] = None,
               names: Iterable[Box] = (), buttons: Iterable[Box] = (),
               beneath: Optional[Places] = None) -> None:
        """Chooses the sides for the present positions.

        labels  -- each robot's label, by the robot's name; earlier labels are placed first
        window  -- the area that people see; None: it is not known
        names   -- boxes of names and of rings, which a label may cover if it must
        buttons -- boxes of buttons, which no label should cover
        beneath -- the edges, as soft boxes
        """
        places = Places(window, beneath=beneath)
        for box in names:
            places.cover(box, is_soft=True, weight=NAME_WEIGHT)
        # The square within the robot's disc. With a larger square, no label at a corner would be
        # free.
        for box in (*buttons, *(box_around((one.x, one.y), (math.sqrt(2.0) * one.radius,) * 2)
                                for one in labels.values())):
            places.cover(box)
        self._sides = {name: places.place(one.boxes(), self._sides.get(name, -1), MayCover.ALL)
                       for name, one in labels.items()}
