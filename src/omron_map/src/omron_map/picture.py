"""Draws a picture of a map with its objects, without ROS.

- Points are black, lines red.
- Goals and docks are green, with their names at the left, and with arrows if they have a heading.
- Forbidden areas and lines are orange, sectors violet.
- A net has light lines every metre and stronger lines every five metres.
- x points to the right, y upwards.
"""
from __future__ import annotations

import math
from typing import Callable, Sequence, Tuple

import numpy as np

from omron_map.canvas import LONG_SIDE, Canvas, Colour
from omron_map.document import MapDocument
from omron_map.errors import MapError
from omron_map.geometry import bounds_of
from omron_map.objects import MapObject

METRE, FIVE_METRES = (240, 241, 243), (224, 226, 230)
BLACK, RED, GREEN = (20, 20, 20), (214, 40, 40), (22, 150, 70)
DARK_GREEN, ORANGE, VIOLET = (8, 90, 40), (245, 140, 20), (125, 80, 190)
AREA_OPACITY = 90  # of 255

PITCH = 20  # mm; pitch of the points if the map gives none
LEAST_POINT = 1.2  # px
SQUARE = 300  # mm
ARROW = 550  # mm
GAP = 75  # mm between an object and its name
LEAST_METRE = 8  # px; lines of the net that would be nearer to each other are not drawn


def draw_map(document: MapDocument, path: str, long_side: int = LONG_SIDE,
             is_named: bool = True) -> Tuple[int, int]:
    """Writes a PNG picture of `document`; returns its size in pixels.

    long_side -- length of its longer side, px
    is_named  -- whether the user gave `path`; if not, a file of another program is not replaced
    Raises MapError if the map is empty or the file cannot be written.
    """
    picture = MapPicture(document, long_side)
    picture.net()
    picture.forbidden()
    picture.sectors()
    picture.walls()
    picture.places()
    return picture.canvas.write(path, is_named)


class MapPicture:
    """A map that is drawn layer by layer; a caller can draw further layers on `canvas`.

    also -- (N, 2), mm: further places that must be inside the picture
    """

    def __init__(self, document: MapDocument, long_side: int = LONG_SIDE,
                 also: Sequence[Sequence[float]] = ()) -> None:
        places = document.goals + document.docks
        bounds = bounds_of(document.points, document.lines, np.array(also, float),
                           np.array([(obj.x, obj.y) for obj in places]))
        if bounds is None:  # areas set the bounds only if there is nothing else
            bounds = bounds_of(*(
                area.outline for area in document.forbidden_areas + document.sectors))
        if bounds is None:
            raise MapError(document.name, 'there is nothing in the map to draw')
        self.canvas = Canvas(*bounds, long_side=long_side)
        self._document = document

    def net(self) -> None:
        """Draws lines every metre and every five metres, if they are distinguishable."""
        low, high = self.canvas.low, self.canvas.high
        for step, colour in ((1000, METRE), (5000, FIVE_METRES)):
            if self.canvas.pixels_of(step) < LEAST_METRE:
                continue
            for axis in (0, 1):
                first = math.ceil(low[axis] / step) * step
                for position in np.arange(first, high[axis], step):
                    ends = np.array((low, high))
                    ends[:, axis] = position
                    self.canvas.polyline(ends, colour, 1)

    def forbidden(self, colour_of: Callable[[MapObject], Colour] = lambda obj: ORANGE) -> None:
        """Draws the forbidden areas and lines."""
        for area in self._document.forbidden_areas:
            self.canvas.polygon(area.outline, colour_of(area), AREA_OPACITY)
            self.canvas.outline(area.outline, colour_of(area), 2)
        for line in self._document.forbidden_lines:
            self.canvas.polyline(line.ends, colour_of(line), 5)

    def sectors(self) -> None:
        """Draws the areas that change the robot's driving, with their names."""
        for sector in self._document.sectors:
            self.canvas.outline(sector.outline, VIOLET, 3)
            self.canvas.text(sector.outline.mean(axis=0), sector.label, VIOLET, 0.5)

    def walls(self) -> None:
        """Draws the points and lines of the laser scan."""
        self.canvas.squares(self._document.points, self._document.resolution or PITCH, BLACK,
                            LEAST_POINT)
        for line in self._document.lines.reshape(-1, 2, 2):
            self.canvas.polyline(line, RED, 1)

    def places(self) -> None:
        """Draws goals and docks with their headings, then their names, so
        that no name is hidden.
        """
        places = self._document.docks + self._document.goals
        for obj in places:
            self.canvas.squares(np.array((obj.x, obj.y)), SQUARE, GREEN)
        for obj in places:
            if obj.has_heading:
                self.canvas.arrow((obj.x, obj.y), obj.theta, ARROW, BLACK, 3)
        for obj in places:
            left, right = _sides(obj)
            if self.canvas.has_room_left_of(left, obj.label):
                self.canvas.text(left, obj.label, DARK_GREEN, 1.0)
            else:
                self.canvas.text(right, obj.label, DARK_GREEN, 0.0)


def _sides(obj: MapObject) -> Tuple[Tuple[float, float], Tuple[float, float]]:
    """Returns where a name at the left ends, and where a name at the right begins.

    Both are outside the square and the arrow of the object.
    """
    left = ARROW if obj.heads_left else SQUARE / 2.0
    right = ARROW if obj.heads_right else SQUARE / 2.0
    return (obj.x - left - GAP, obj.y), (obj.x + right + GAP, obj.y)
