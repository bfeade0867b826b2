"""A picture of a map with its objects, to look at without ROS.

Points are black, lines red, goals and docks green with their names at the left and arrows where
they have a heading, forbidden areas and lines orange, sectors violet. Light lines stand one metre
apart, stronger ones five. North is up: x to the right, y upwards.
"""
from __future__ import annotations

import io
import math
from typing import Iterable, List, Tuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from omron_map.document import MapDocument
from omron_map.errors import MapError
from omron_map.objects import MapObject
from omron_map.saving import write_file

PAPER = (255, 255, 255)
METRE, FIVE_METRES = (240, 241, 243), (224, 226, 230)
BLACK, RED, GREEN = (20, 20, 20), (214, 40, 40), (22, 150, 70)
DARK_GREEN, ORANGE, VIOLET = (8, 90, 40), (245, 140, 20), (125, 80, 190)
AREA_OPACITY = 90  # of 255

LONG_SIDE = 1600  # px, default
SUPERSAMPLING = 2  # drawn larger by this, then scaled down: smooth edges without a toolkit
MARGIN = 500  # mm around what is drawn
SQUARE = 300  # mm
ARROW = 550  # mm
GAP = 75  # mm between a name and what it names
#: Fonts with more than Latin letters, where they are installed; else Pillow's own small one.
FONTS = ('NotoSansCJK-Regular.ttc', 'NanumGothic.ttf', 'DejaVuSans.ttf',
         'LiberationSans-Regular.ttf')
BASIC_LAYOUT = 0  # the other one, for scripts that join letters, crashes with Ubuntu 20.04's Pillow


def draw_map(document: MapDocument, path: str, long_side: int = LONG_SIDE) -> Tuple[int, int]:
    """Write a PNG picture of `document`, `long_side` pixels at its longer side; returns its size.

    Raises MapError when the map is empty or the file cannot be written.
    """
    picture = _Picture(document, long_side)
    picture.draw(document)
    image = picture.finish()
    buffer = io.BytesIO()
    image.save(buffer, 'PNG', optimize=True)
    write_file(path, buffer.getvalue())
    return image.size


class _Picture:
    """The drawing surface: coordinates in mm go in, pixels come out."""

    def __init__(self, document: MapDocument, long_side: int) -> None:
        low, high = _bounds(document)
        self._low, self._high = low - MARGIN, high + MARGIN
        size = self._high - self._low
        self._scale = SUPERSAMPLING * long_side / size.max()  # px per mm
        width, height = np.ceil(size * self._scale / SUPERSAMPLING).astype(int) * SUPERSAMPLING
        self._image = Image.new('RGB', (int(width), int(height)), PAPER)
        self._pen = ImageDraw.Draw(self._image, 'RGBA')
        self._font = _font(max(26 * SUPERSAMPLING * long_side // LONG_SIDE, 12))
        self._scalable = isinstance(self._font, ImageFont.FreeTypeFont)
        _, top, bottom = _extent(self._font, 'H')
        self._middle = (top + bottom) / 2.0  # from the top of a line of text, px

    def draw(self, document: MapDocument) -> None:
        """Everything, from the floor up."""
        self._metres()
        for area in document.forbidden_areas:
            self._pen.polygon(self._pixels(area.outline), fill=ORANGE + (AREA_OPACITY,))
            self._polyline(_closed(area.outline), ORANGE, 2)
        for sector in document.sectors:
            self._polyline(_closed(sector.outline), VIOLET, 3)
        self._points(document.points, document.resolution or 20)
        for line in document.lines.reshape(-1, 2, 2):
            self._polyline(line, RED, 1)
        for line in document.forbidden_lines:
            extent = line.extent
            self._polyline(((extent.from_x, extent.from_y), (extent.to_x, extent.to_y)), ORANGE, 5)
        for obj in document.docks + document.goals:
            self._square(obj)
        for obj in document.docks + document.goals:
            if obj.has_heading:
                self._arrow(obj)
        for sector in document.sectors:
            self._text(sector.outline.mean(axis=0), sector.label, VIOLET, 0.5)
        for obj in document.docks + document.goals:
            gap = ARROW + GAP if obj.heads_left else SQUARE / 2.0 + GAP
            self._text((obj.x - gap, obj.y), obj.label, DARK_GREEN, 1.0)

    def finish(self) -> Image.Image:
        """The picture at its real size."""
        width, height = self._image.size
        return self._image.resize((width // SUPERSAMPLING, height // SUPERSAMPLING),
                                  Image.LANCZOS)

    def _pixels(self, positions: np.ndarray) -> List[Tuple[float, float]]:
        """Positions (N, 2) in mm as pixels; y grows downwards there."""
        positions = np.asarray(positions, float).reshape(-1, 2)
        x = (positions[:, 0] - self._low[0]) * self._scale
        y = (self._high[1] - positions[:, 1]) * self._scale
        return list(zip(x.tolist(), y.tolist()))

    def _metres(self) -> None:
        """A net of lines one metre apart, as long as they stay distinguishable."""
        for step, colour in ((1000, METRE), (5000, FIVE_METRES)):
            if step * self._scale < 8 * SUPERSAMPLING:
                continue
            for axis in (0, 1):
                first = math.ceil(self._low[axis] / step) * step
                for position in np.arange(first, self._high[axis], step):
                    ends = np.array((self._low, self._high), float)
                    ends[:, axis] = position
                    self._polyline(ends, colour, 1)

    def _points(self, points: np.ndarray, pitch: int) -> None:
        """A black square of the pitch, at least one pixel of the final picture, for each point."""
        half = max(pitch * self._scale, SUPERSAMPLING * 1.2) / 2.0
        for x, y in self._pixels(points):
            self._pen.rectangle((x - half, y - half, x + half, y + half), fill=BLACK)

    def _polyline(self, positions: Iterable, colour: Tuple[int, int, int], width: int) -> None:
        self._pen.line(self._pixels(positions), fill=colour, width=width * SUPERSAMPLING)

    def _square(self, obj: MapObject) -> None:
        half = SQUARE / 2.0
        corners = ((obj.x - half, obj.y + half), (obj.x + half, obj.y - half))
        self._pen.rectangle(self._pixels(corners), fill=GREEN)

    def _arrow(self, obj: MapObject) -> None:
        """A black arrow from the object along its heading."""
        heading = math.radians(obj.theta)
        along = np.array((math.cos(heading), math.sin(heading)))
        across = np.array((-along[1], along[0]))
        tail = np.array((obj.x, obj.y), float)
        tip, neck = tail + along * ARROW, tail + along * ARROW * 0.55
        self._polyline((tail, neck), BLACK, 3)
        wing = across * ARROW * 0.2
        self._pen.polygon(self._pixels((tip, neck + wing, neck - wing)), fill=BLACK)

    def _text(self, position: Iterable[float], text: str, colour: Tuple[int, int, int],
              left_share: float) -> None:
        """Text with a white rim, `left_share` of it left of a place in mm, kept in the picture."""
        if not self._scalable:  # Pillow's own font, which is Latin only
            text = text.encode('latin-1', 'replace').decode('latin-1')
        if not text.strip():
            return
        (x, y), = self._pixels(position)
        width, _, _ = _extent(self._font, text)
        x = min(max(x - width * left_share, 4 * SUPERSAMPLING), self._image.size[0] - width)
        rim = {'stroke_width': 2 * SUPERSAMPLING, 'stroke_fill': PAPER} if self._scalable else {}
        self._pen.text((x, y - self._middle), text, fill=colour, font=self._font, **rim)


def _bounds(document: MapDocument) -> Tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates to be seen; areas count only where there is nothing else."""
    seen = [document.points, document.lines.reshape(-1, 2),
            np.array([(obj.x, obj.y) for obj in document.goals + document.docks]).reshape(-1, 2)]
    everything = np.concatenate(seen)
    if not len(everything):
        areas = [area.outline for area in document.forbidden_areas + document.sectors]
        if not areas:
            raise MapError(document.name, 'there is nothing in the map to draw')
        everything = np.concatenate(areas)
    return everything.min(axis=0), everything.max(axis=0)


def _closed(outline: np.ndarray) -> np.ndarray:
    return np.concatenate((outline, outline[:1]))


def _font(size: int) -> ImageFont.ImageFont:
    for name in FONTS:
        try:
            return ImageFont.truetype(name, size, layout_engine=BASIC_LAYOUT)
        except OSError:
            continue
    return ImageFont.load_default()


def _extent(font: ImageFont.ImageFont, text: str) -> Tuple[int, int, int]:
    """Width of `text`, and its top and bottom from the top of a line, px."""
    if hasattr(font, 'getbbox'):
        _, top, right, bottom = font.getbbox(text)
        return right, top, bottom
    width, height = font.getsize(text)  # Pillow before 8
    return width, font.getoffset(text)[1] if hasattr(font, 'getoffset') else 0, height
