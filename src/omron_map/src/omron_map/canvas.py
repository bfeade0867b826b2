"""A picture in the coordinates of a map: input in mm, output in pixels; x right, y upwards."""
from __future__ import annotations

import io
import math
from typing import Any, List, Sequence, Tuple, Union

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from omron_map.saving import png_notes, write_file

Colour = Tuple[int, int, int]
Place = Union[Sequence[float], np.ndarray]

PAPER: Colour = (255, 255, 255)
LONG_SIDE = 1600  # px, default
SUPERSAMPLING = 2  # the picture is drawn larger by this factor and scaled down: smooth edges
MARGIN = 500  # mm around the contents
TEXT_HEIGHT = 26  # px, if the longer side of the picture is LONG_SIDE
LEAST_TEXT_HEIGHT = 12
EDGE = 4  # px between text and the edges of the picture
ARROW_NECK, ARROW_WING = 0.55, 0.2  # start and half width of the head / arrow length
#: Fonts with more than Latin letters, if they are installed; otherwise Pillow's own small font.
FONTS = ('NotoSansCJK-Regular.ttc', 'NanumGothic.ttf', 'DejaVuSans.ttf',
         'LiberationSans-Regular.ttf')
#: The layout engine of Pillow. Pillow's second engine, for scripts that join letters, crashes in
#: Ubuntu 20.04. The Pillow of Ubuntu 20.04 takes a number; newer versions have a class for it.
BASIC_LAYOUT: Any = 0
Font = Union[ImageFont.FreeTypeFont, ImageFont.ImageFont]


class Canvas:
    """A picture of the floor from `low` to `high` (x, y in mm) with MARGIN around it.

    long_side -- length of the longer side, px. The widths of lines are in pixels.
    """

    def __init__(self, low: Place, high: Place, long_side: int = LONG_SIDE) -> None:
        self.low, self.high = np.asarray(low, float) - MARGIN, np.asarray(high, float) + MARGIN
        size = self.high - self.low
        self._scale = SUPERSAMPLING * long_side / size.max()  # px per mm
        width, height = np.ceil(size * self._scale / SUPERSAMPLING).astype(int) * SUPERSAMPLING
        self._image = Image.new('RGB', (int(width), int(height)), PAPER)
        self._pen = ImageDraw.Draw(self._image, 'RGBA')
        self._font = label_font(max(TEXT_HEIGHT * SUPERSAMPLING * long_side // LONG_SIDE,
                                    LEAST_TEXT_HEIGHT))
        self._scalable = isinstance(self._font, ImageFont.FreeTypeFont)
        _, top, bottom = _extent(self._font, 'H')
        self._middle = (top + bottom) / 2.0  # px from the top of a text to its middle

    def pixels_of(self, length: float) -> float:
        """Returns the length, in pixels of the finished picture, of a length in mm."""
        return length * self._scale / SUPERSAMPLING

    def polyline(self, places: np.ndarray, colour: Colour, width: int) -> None:
        """Draws a line through `places` (N, 2)."""
        self._pen.line(self._pixels(places), fill=colour, width=width * SUPERSAMPLING)

    def outline(self, corners: np.ndarray, colour: Colour, width: int) -> None:
        """Draws a closed line around `corners` (N, 2)."""
        self.polyline(np.concatenate((corners, corners[:1])), colour, width)

    def polygon(self, corners: np.ndarray, colour: Colour, opacity: int = 255) -> None:
        """Fills the area within `corners` (N, 2); an `opacity` below 255 makes it transparent."""
        self._pen.polygon(self._pixels(corners), fill=colour + (opacity,))

    def squares(self, centres: np.ndarray, side: float, colour: Colour,
                least: float = 0.0) -> None:
        """Draws squares of `side` mm, at least `least` pixels, around `centres` (N, 2)."""
        half = max(side * self._scale, least * SUPERSAMPLING) / 2.0
        for x, y in self._pixels(centres):
            self._pen.rectangle((x - half, y - half, x + half, y + half), fill=colour)

    def arrow(self, tail: Place, degrees: float, length: float, colour: Colour,
              width: int) -> None:
        """Draws an arrow from `tail` with the given `length` (mm) and direction (degrees)."""
        along = length * np.array((math.cos(math.radians(degrees)),
                                   math.sin(math.radians(degrees))))
        wing = ARROW_WING * np.array((-along[1], along[0]))
        neck = tail + ARROW_NECK * along
        self.polyline(np.stack((tail, neck)), colour, width)
        self.polygon(np.stack((tail + along, neck + wing, neck - wing)), colour)

    def text(self, place: Place, words: str, colour: Colour, left_share: float) -> None:
        """Draws text with a white rim, inside the picture.

        left_share -- the share of the text that is left of `place`, 0..1
        """
        words = self._drawable(words)
        if not words.strip():
            return
        (x, y), = self._pixels(place)
        width = self._width(words)
        edge = EDGE * SUPERSAMPLING
        x = max(min(x - width * left_share, self._image.size[0] - width - edge), edge)
        rim = 2 * SUPERSAMPLING if self._scalable else 0  # Pillow's own font can have no rim
        self._pen.text((x, y - self._middle), words, fill=colour, font=self._font,
                       stroke_width=rim, stroke_fill=PAPER if rim else None)

    def has_room_left_of(self, place: Place, words: str) -> bool:
        """Returns whether a text that ends at `place` begins inside the picture."""
        (x, _), = self._pixels(place)
        return x - self._width(self._drawable(words)) >= EDGE * SUPERSAMPLING

    def write(self, path: str, is_named: bool = True) -> Tuple[int, int]:
        """Writes the picture as a PNG file in one step; returns its size in pixels.

        is_named -- whether the user gave `path`; if not, an existing file is replaced only if
                    ld_map wrote it
        Raises MapError if the file cannot be written.
        """
        width, height = self._image.size
        image = self._image.resize((width // SUPERSAMPLING, height // SUPERSAMPLING),
                                   Image.LANCZOS)
        buffer = io.BytesIO()
        image.save(buffer, 'PNG', optimize=True, pnginfo=png_notes())
        write_file(path, buffer.getvalue(), is_named=is_named)
        return image.size

    def _pixels(self, places: Place) -> List[Tuple[float, float]]:
        """Converts `places` (N, 2) from mm to pixels, in which y grows downwards."""
        x, y = np.asarray(places, float).reshape(-1, 2).T
        return list(zip(((x - self.low[0]) * self._scale).tolist(),
                        ((self.high[1] - y) * self._scale).tolist()))

    def _drawable(self, words: str) -> str:
        if self._scalable:
            return words
        return words.encode('latin-1', 'replace').decode('latin-1')  # for Pillow's own font

    def _width(self, words: str) -> int:
        return _extent(self._font, words)[0]


def label_font(size: int) -> Font:
    """Returns a font of `size` px for labels: the first of FONTS that is installed."""
    for name in FONTS:
        try:
            return ImageFont.truetype(name, size, layout_engine=BASIC_LAYOUT)
        except OSError:
            continue
    return ImageFont.load_default()


def _extent(font: Any, words: str) -> Tuple[int, int, int]:
    """Returns the width of `words` in a font, and their top and bottom in the line, all in px."""
    if hasattr(font, 'getbbox'):
        _, top, right, bottom = font.getbbox(words)
        return right, top, bottom
    width, height = font.getsize(words)  # Pillow before 8
    return width, font.getoffset(words)[1] if hasattr(font, 'getoffset') else 0, height
