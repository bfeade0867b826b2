"""Finds places for the ids and labels of vertices, so that no text covers another.

A text is at its usual place if this place is free, otherwise at the nearest free place around its
vertex. If no place within REACH is free, the text is not shown. To keep the picture steady, only
texts that have changed, or that are not at their usual places, get new places.
"""
from __future__ import annotations

from typing import Dict, List, Mapping, NamedTuple, Optional, Tuple

from trajectory_graph.placing import Box, Places, box_around

Point = Tuple[float, float]
Key = Tuple[str, int]  # the kind of the text, and the id of its vertex

REACH = 1.5   # m; largest distance between the edge of a text and its vertex
STEP = 0.15   # m between two possible places in the outward direction
MARGIN = 0.2  # m between a vertex and the nearest text that is not at its usual place
LINE_HEIGHT = 1.1  # as a multiple of the text height
# Widths of letters in Liberation Sans, the font of RViz, in 1/1000 of the font's size: for each
# width, its letters. All other letters are OTHER_WIDTH wide. A space is drawn as wide as an A.
_WIDTHS = {191: "'", 222: 'ijl', 278: '!,./:;I[]\\ftr', 333: '()-`', 355: '"', 389: '*',
           500: 'JcksvxyzZ', 556: '#$0123456789?L_abdeghnopqu', 584: '+<=>~', 611: 'FT',
           667: ' &ABEKPSVXY', 722: 'CDHNRUw', 778: 'GOQ', 833: 'Mm', 889: '%', 944: 'W'}
_WIDTH_OF = {letter: width / 1000.0 for width, letters in _WIDTHS.items() for letter in letters}
OTHER_WIDTH = 0.72
# measured in RViz: width of a letter that is 1 wide in the font, for a text height of 1
TEXT_SCALE = 0.82
# Right and left are tried last, because edges are often there.
_SIDES = ((0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1), (1, 0), (-1, 0))


class VertexText(NamedTuple):
    """A text beside a vertex; lengths in m.

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
        self._places = Places()

    def middle(self, key: Key) -> Optional[Point]:
        """Returns the middle of a text (m); None: there is no free place for the text."""
        return self._middles[key]

    def show(self, texts: Mapping[Key, VertexText]) -> None:
        """Places these texts in their order."""
        for key, text in list(self._texts.items()):
            if texts.get(key) != text or self._middles[key] != _usual(text):
                self._remove(key)
        for key, text in texts.items():
            if key not in self._texts:
                self._place(key, text)

    def _remove(self, key: Key) -> None:
        del self._texts[key], self._middles[key]
        box = self._boxes.pop(key, None)
        if box is not None:
            self._places.uncover(box)

    def _place(self, key: Key, text: VertexText) -> None:
        self._texts[key], self._middles[key] = text, None
        middles = _middles(text)
        boxes = [box_around(middle, text.size) for middle in middles]
        number = self._places.place(boxes)
        if number >= 0:
            self._middles[key], self._boxes[key] = middles[number], boxes[number]


def text_size(words: str, height: float) -> Tuple[float, float]:
    """Returns the approximate width and height of a text in RViz."""
    lines = words.split('\n')
    width = max(sum(_WIDTH_OF.get(letter, OTHER_WIDTH) for letter in line) for line in lines)
    return TEXT_SCALE * height * width, LINE_HEIGHT * height * len(lines)


def _usual(text: VertexText) -> Point:
    return text.vertex[0] + text.usual[0], text.vertex[1] + text.usual[1]


def _middles(text: VertexText) -> List[Point]:
    """Returns the possible middles of a text, the best first: the usual place, then near to far."""
    (x, y), (width, height) = text.vertex, text.size
    return [_usual(text), *(
        (x + right * (away + width / 2.0), y + up * (away + height / 2.0))
        for ring in range(int((REACH - MARGIN) / STEP) + 1)
        for away in (MARGIN + ring * STEP,) for right, up in _SIDES)]
