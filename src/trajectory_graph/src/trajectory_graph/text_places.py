"""Finds places for the ids and labels of a drawn graph, so that no text covers another.

A text is at its usual place if that is free, otherwise at the nearest free place around its vertex.
A place is free if no other text is there, and preferably no line. If there is no free place within
REACH, the text is not shown. To keep the picture steady, only texts that have changed, and texts
that are not at their usual places, get new places.
"""
from __future__ import annotations

import math
from itertools import product
from typing import Dict, Iterable, Iterator, Mapping, NamedTuple, Optional, Set, Tuple

import numpy as np

Point = Tuple[float, float]
Box = Tuple[float, float, float, float]  # left, lower, right, upper; m
Cell = Tuple[int, int]
Key = Tuple[str, int]  # the kind of the text, and the id of its vertex

REACH = 1.5   # m; largest distance between the edge of a text and its vertex
STEP = 0.15   # m between two places in the outward direction
MARGIN = 0.2  # m between a vertex and the nearest text that is not at its usual place
LETTER_WIDTH, LINE_HEIGHT = 0.6, 1.1  # shares of the text height in RViz's font; few are wider
_CELL = 1.0   # m; cell size of the grid for finding neighbouring texts
_DOT = 0.1    # m; cell size of the grid of lines
# Right and left are tried last, because edges are often there.
_SIDES = ((0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1), (1, 0), (-1, 0))


class VertexText(NamedTuple):
    """A text beside a vertex, m.

    size  -- width and height of the text
    usual -- the middle of the text at its usual place, relative to the vertex
    """

    vertex: Point
    size: Point
    usual: Point


class TextPlaces:
    """The places of all texts; each text has a unique key."""

    def __init__(self) -> None:
        self._texts: Dict[Key, VertexText] = {}
        self._middles: Dict[Key, Optional[Point]] = {}
        self._boxes: Dict[Key, Box] = {}
        self._cells: Dict[Cell, Set[Key]] = {}
        self._lines: Set[Cell] = set()

    def middle(self, key: Key) -> Optional[Point]:
        """Returns the middle of a text (m); None if there is no free place for it."""
        return self._middles[key]

    def avoid(self, lines: Iterable[np.ndarray]) -> None:
        """Sets the lines, each of points (N,2), that texts avoid if they can.

        All texts get new places at the next `show`.
        """
        self._lines = set()
        for line in lines:
            points = np.asarray(line, float)
            for start, end in zip(points, points[1:]):
                steps = int(np.abs(end - start).max() * 2.0 / _DOT) + 2
                dots = np.floor((start + np.linspace(0.0, 1.0, steps)[:, None] * (end - start))
                                / _DOT).astype(int)
                self._lines.update((x, y) for x, y in dots.tolist())
        for key in list(self._texts):
            self._remove(key)

    def show(self, texts: Mapping[Key, VertexText]) -> None:
        """Places these texts; the first ones choose first."""
        for key, text in list(self._texts.items()):
            if texts.get(key) != text or self._middles[key] != _usual(text):
                self._remove(key)
        for key, text in texts.items():
            if key not in self._texts:
                self._place(key, text)

    def _remove(self, key: Key) -> None:
        del self._texts[key], self._middles[key]
        box = self._boxes.pop(key, None)
        for cell in () if box is None else _cells(box):
            self._cells[cell].discard(key)

    def _place(self, key: Key, text: VertexText) -> None:
        self._texts[key], self._middles[key] = text, None
        found: Optional[Tuple[Point, Box]] = None
        for middle in _places(text):
            box = _box(middle, text.size)
            if self._is_free(box):
                found = found or (middle, box)
                if not self._covers_a_line(box):
                    found = middle, box
                    break
        if found is None:
            return
        self._middles[key], self._boxes[key] = found
        for cell in _cells(found[1]):
            self._cells.setdefault(cell, set()).add(key)

    def _is_free(self, box: Box) -> bool:
        return not any(overlap(box, self._boxes[key])
                       for cell in _cells(box) for key in self._cells.get(cell, ()))

    def _covers_a_line(self, box: Box) -> bool:
        return bool(self._lines) and any(dot in self._lines for dot in _cells(box, _DOT))


def text_size(words: str, height: float) -> Tuple[float, float]:
    """Returns the approximate width and height of a text in RViz."""
    lines = words.split('\n')
    return LETTER_WIDTH * height * max(map(len, lines)), LINE_HEIGHT * height * len(lines)


def overlap(one: Box, other: Box) -> bool:
    """Returns whether two texts overlap."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _usual(text: VertexText) -> Point:
    return text.vertex[0] + text.usual[0], text.vertex[1] + text.usual[1]


def _places(text: VertexText) -> Iterator[Point]:
    """Yields possible middles, the best first: the usual one, then outwards on all sides."""
    yield _usual(text)
    (x, y), (width, height) = text.vertex, text.size
    for ring in range(int((REACH - MARGIN) / STEP) + 1):
        away = MARGIN + ring * STEP
        for right, up in _SIDES:
            yield x + right * (away + width / 2.0), y + up * (away + height / 2.0)


def _box(middle: Point, size: Point) -> Box:
    (x, y), (width, height) = middle, size
    return x - width / 2.0, y - height / 2.0, x + width / 2.0, y + height / 2.0


def _cells(box: Box, size: float = _CELL) -> Iterator[Cell]:
    left, lower, right, upper = (math.floor(side / size) for side in box)
    return product(range(left, right + 1), range(lower, upper + 1))
