"""A picture of a converted map: walls, corridors, fences, places. The map is in mm."""
from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from shapely.geometry.base import BaseGeometry

from omron_ld90.converter.converter import Conversion
from omron_ld90.converter.fence_check import shape_of
from omron_ld90.converter.fences import is_fence
from omron_map import MapDocument, MapError, MapObject
from omron_map.picture import BASIC_LAYOUT
from trajectory_graph import Graph

LARGEST_SIDE = 2000  # pixels
SCALE = 1.0 / 15.0  # pixels per mm, for maps that are not too large for it
BORDER = 500.0  # mm
WHITE, BLACK, GREY = (255, 255, 255), (0, 0, 0), (110, 110, 110)
CORRIDOR, CURVE = (214, 232, 250), (20, 90, 190)
FENCE, FENCE_EDGE, FORBIDDEN = (255, 176, 84), (214, 120, 10), (226, 132, 110)
GOAL, DOCK = (0, 140, 60), (150, 0, 150)


def draw(document: MapDocument, graph: Graph, conversion: Conversion, path: str) -> None:
    """Draw the converted map into the PNG file `path`; raises MapError when it cannot be written.

    Walls are black, corridors light blue, curves blue, fences orange, other forbidden areas and
    lines red, goals green, docks purple; a dash tells the heading.
    """
    floor = conversion.corridors.floor
    bounds = [floor.bounds, *(shape_of(fence).bounds for fence in conversion.fences)]
    sheet = _Sheet(np.concatenate(
        [document.points, document.lines.reshape(-1, 2), np.reshape(bounds, (-1, 2))]))
    for part in getattr(floor, 'geoms', [floor]):
        sheet.area(part)
    objects = sorted(document.forbidden_areas + document.forbidden_lines,
                     key=is_fence, reverse=True)
    for obj in objects:
        sheet.forbidden(obj)
    sheet.walls(document.points, document.lines)
    for id in graph.edges:
        sheet.line(graph.curve(id).points * 1000.0, CURVE, 2)
    for place in conversion.places:
        sheet.place(place)
    sheet.save(path)


class _Sheet:
    """An image with the map's coordinates."""

    def __init__(self, shown: np.ndarray) -> None:
        """`shown` (N,2) are points that must be on it."""
        self._low, self._high = shown.min(axis=0) - BORDER, shown.max(axis=0) + BORDER
        size = self._high - self._low
        self._scale = min(SCALE, LARGEST_SIDE / size.max())
        self._image = Image.new('RGB', tuple(int(side) for side in size * self._scale), WHITE)
        self._pen = ImageDraw.Draw(self._image)
        self._font = _font(14)

    def _pixels(self, points: np.ndarray) -> Sequence[Tuple[float, float]]:
        x, y = np.asarray(points, float).reshape(-1, 2).T
        return list(zip(((x - self._low[0]) * self._scale).tolist(),
                        ((self._high[1] - y) * self._scale).tolist()))

    def area(self, polygon: BaseGeometry) -> None:
        """A piece of floor, with its holes."""
        self._pen.polygon(self._pixels(polygon.exterior.coords), fill=CORRIDOR)
        for hole in polygon.interiors:
            self._pen.polygon(self._pixels(hole.coords), fill=WHITE)

    def forbidden(self, obj: MapObject) -> None:
        """A forbidden area or line."""
        fill, edge = (FENCE, FENCE_EDGE) if is_fence(obj) else (FORBIDDEN, FORBIDDEN)
        if obj.is_area:
            self._pen.polygon(self._pixels(obj.rectangle.corners), fill=fill, outline=edge)
        else:
            extent = obj.extent
            self.line(((extent.from_x, extent.from_y), (extent.to_x, extent.to_y)), edge, 3)

    def walls(self, points: np.ndarray, lines: np.ndarray) -> None:
        """What the laser saw."""
        for line in lines:
            self.line(line, GREY, 1)
        self._pen.point([pixel for pair in self._pixels(points) for pixel in pair], fill=BLACK)

    def line(self, points: np.ndarray, colour: Tuple[int, int, int], width: int) -> None:
        """A polyline."""
        self._pen.line(self._pixels(points), fill=colour, width=width)

    def place(self, obj: MapObject) -> None:
        """A goal or a dock with its name and, where it has one, its heading."""
        (x, y), = self._pixels((obj.x, obj.y))
        colour = DOCK if obj.is_dock else GOAL
        if obj.has_heading:
            turn = np.radians(obj.theta)
            self._pen.line([(x, y), (x + 16 * np.cos(turn), y - 16 * np.sin(turn))],
                           fill=colour, width=3)
        self._pen.ellipse([x - 5, y - 5, x + 5, y + 5], fill=colour)
        self._pen.text((x + 7, y - 18), obj.label, fill=colour, font=self._font)

    def save(self, path: str) -> None:
        """Write the image."""
        try:
            self._image.save(path, format='PNG')
        except OSError as error:
            raise MapError(path, f'the picture cannot be written ({error.strerror})') from error


def _font(size: int) -> ImageFont.ImageFont:
    """A scalable font where the system has one, else Pillow's own."""
    for name in ('DejaVuSans.ttf', 'LiberationSans-Regular.ttf'):
        try:
            return ImageFont.truetype(name, size, layout_engine=BASIC_LAYOUT)
        except OSError:
            continue
    return ImageFont.load_default()
