"""Map objects: the contents of `Cairn:` lines.

    Cairn: <kind> <x> <y> <theta> "<description>" <icon> "<name>" [<from x y> <to x y> [<more>]]
"""
from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np

from omron_map.errors import FieldError
from omron_map.geometry import Extent, RotatedRectangle, normalise_degrees
from omron_map.text import encode, printable
from omron_map.tokens import Token, quoted

LINE_KINDS = frozenset(
    ('ForbiddenLine', 'Measure', 'PreferredLine', 'ResistedLine', 'DistanceAdjustment'))
#: These objects look like areas at the origin, but they are configuration and are not drawn.
CONFIGURATION_KINDS = frozenset(('FeedbackHandler', 'RobotArrivalHandler'))
HEADING_SUFFIX = 'WithHeading'
DEFAULT_ICON = 'ICON'
MAX_LINE_BYTES = 10_000  # a line must be shorter: this is the size of the vendor's buffer
MAX_LINE_WORDS = 512

_FIELDS = ('kind', 'x', 'y', 'theta', 'description', 'icon', 'name')
_EXTENT_FIELDS = ('from x', 'from y', 'to x', 'to y')
_DECIMAL = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?', re.ASCII)
_INTEGER = re.compile(r'[-+]?\d+', re.ASCII)
_LARGEST = 2**31 - 1


@dataclass(frozen=True)
class MapObject:
    """One object of a map: x, y in mm and theta in degrees, counter-clockwise, map frame.

    x, y   -- points: the position; areas: 0 (see `rectangle`); lines: the from point
    theta  -- the heading; has no meaning for goals without heading
    extent -- the corners or end points of areas and lines; None for points
    tail   -- the words after the extent as written, e.g. a polygon

    It has a property for each question about its kind or its shape.
    """

    kind: str
    x: float
    y: float
    theta: float
    description: str = ''
    icon: str = DEFAULT_ICON
    name: str = ''
    extent: Optional[Extent] = None
    tail: Tuple[str, ...] = ()

    @classmethod
    def goal(cls, name: str, x: float, y: float, heading: Optional[float] = None,
             description: str = '') -> MapObject:
        """Returns a goal; with a `heading` (degrees) the robot turns to it on arrival."""
        if heading is None:
            return cls('Goal', x, y, 0.0, description, name=name)
        return cls('Goal' + HEADING_SUFFIX, x, y, normalise_degrees(heading), description,
                   name=name)

    @classmethod
    def dock(cls, name: str, x: float, y: float, heading: float,
             kind: str = 'DockLynx') -> MapObject:
        """Returns a dock. `x`, `y` is where the robot arrives before it drives into the station.

        heading -- the direction into the station, degrees
        """
        return cls(kind, x, y, normalise_degrees(heading), name=name)

    @classmethod
    def forbidden_area(cls, rectangle: RotatedRectangle, name: str = '',
                       description: str = '') -> MapObject:
        """Returns a rectangle that the robot must not enter."""
        return cls('ForbiddenArea', 0.0, 0.0, normalise_degrees(rectangle.yaw), description,
                   name=name, extent=rectangle.to_extent())

    @classmethod
    def forbidden_line(cls, x1: float, y1: float, x2: float, y2: float, name: str = '',
                       description: str = '') -> MapObject:
        """Returns a line that the robot must not cross."""
        extent = Extent(round(x1), round(y1), round(x2), round(y2))
        return cls('ForbiddenLine', extent.from_x, extent.from_y, 0.0, description, name=name,
                   extent=extent)

    @property
    def base_kind(self) -> str:
        """The kind without the suffix `WithHeading`."""
        if self.kind.endswith(HEADING_SUFFIX):
            return self.kind[:-len(HEADING_SUFFIX)]
        return self.kind

    @property
    def is_goal(self) -> bool:
        """Whether the command `goto` can drive to it: Goal, StandbyGoal or DoorGoal, with or
        without heading.
        """
        return self.base_kind.endswith('Goal')

    @property
    def is_dock(self) -> bool:
        """Whether the command `dock` can drive to it: its kind begins with `Dock`."""
        return self.kind.startswith('Dock')

    @property
    def is_home(self) -> bool:
        """Whether it is a place where the robot may localize itself after start-up."""
        return self.kind == 'RobotHome'

    @property
    def is_line(self) -> bool:
        """Whether it is a line, from the first to the second point of `extent`."""
        return self.kind in LINE_KINDS

    @property
    def is_area(self) -> bool:
        """Whether it is a rotated rectangle, see `rectangle`."""
        return (self.extent is not None and not self.is_line
                and self.kind not in CONFIGURATION_KINDS)

    @property
    def has_heading(self) -> bool:
        """Whether `theta` is the heading that the robot must have here."""
        return (self.kind.endswith(HEADING_SUFFIX) or self.is_dock
                or (self.is_home and self.extent is None) or self.kind == 'LynxDockTarget')

    @property
    def heads_left(self) -> bool:
        """Whether an arrow along the heading points to the left, where a name could be."""
        return self.has_heading and math.cos(math.radians(self.theta)) < -0.8

    @property
    def heads_right(self) -> bool:
        """Whether an arrow along the heading points to the right, where a name could be."""
        return self.has_heading and math.cos(math.radians(self.theta)) > 0.8

    @property
    def ends(self) -> np.ndarray:
        """(2, 2) end points of a line in mm; raises ValueError for other kinds."""
        if self.extent is None or not self.is_line:
            raise ValueError(f'{self} is not a line')
        return np.array(dataclasses.astuple(self.extent)).reshape(2, 2)

    @property
    def label(self) -> str:
        """The name for people, even if the file is not UTF-8; see `omron_map.text`."""
        return printable(self.name)

    @property
    def key(self) -> str:
        """The key for a search by name; see `name_key`."""
        return name_key(self.name)

    def __str__(self) -> str:
        kind = printable(self.kind)
        return f'{kind} {self.label!r}' if self.name else kind

    @property
    def rectangle(self) -> RotatedRectangle:
        """The rectangle of an area in the map frame; raises ValueError for points and lines."""
        if self.extent is None or not self.is_area:
            raise ValueError(f'{self} is not an area')
        return RotatedRectangle.from_extent(self.extent, self.theta)

    @property
    def polygon(self) -> Optional[np.ndarray]:
        """(n, 2) vertices, mm, of the polygon in an area's tail; None: there is no valid one."""
        if not self.is_area or not all(_INTEGER.fullmatch(word) for word in self.tail):
            return None
        numbers = [int(word) for word in self.tail]
        if len(numbers) < 7 or len(numbers) != 1 + 2 * numbers[0]:
            return None
        return np.array(numbers[1:]).reshape(-1, 2)

    @property
    def outline(self) -> np.ndarray:
        """(n, 2) corners, mm, of an area for drawing.

        A polygon is used only if theta is 0, because it is unknown whether its vertices rotate with
        theta. Otherwise these are the corners of the rectangle.
        """
        polygon = self.polygon
        if polygon is not None and self.theta == 0.0:
            return polygon.astype(float)
        return self.rectangle.corners

    @property
    def anchor(self) -> Tuple[float, float, float]:
        """The sort position (x, y, theta) in the vendor's tools.

        For areas and lines it consists of `from_x`, `from_y` and 0.
        """
        if self.extent is not None:
            return float(self.extent.from_x), float(self.extent.from_y), 0.0
        return self.x, self.y, self.theta

    @property
    def order(self) -> Tuple:
        """The sort key of the vendor's tools."""
        return self.anchor + (self.is_area or self.is_line, self.kind, self.name)


def name_key(name: str) -> str:
    """Returns a key that is the same for equal names; case and encoding make no difference."""
    return printable(name).lower()


def needs_extent(kind: str) -> bool:
    """Returns whether a kind is known to be an area or a line."""
    return kind in ('ForbiddenArea', 'Door') or kind in LINE_KINDS or kind.endswith('Sector')


def parse_object(line: str, words: Sequence[Token]) -> MapObject:
    """Returns the object in the `Cairn:` line with these words; raises FieldError."""
    words = words[1:]
    if len(words) < len(_FIELDS):
        raise FieldError(f'an object with {len(words)} fields', 'Cairn', ', '.join(_FIELDS))
    texts = [word.text for word in words]
    kind, name = texts[0], texts[6]
    x, y, theta = (parse_decimal(texts[i], _FIELDS[i]) for i in (1, 2, 3))
    extent, rest = _parse_extent(kind, texts[7:])
    tail = tuple(line[word.start:word.end] for word in words[len(words) - rest:]) if rest else ()
    return MapObject(kind, x, y, theta, texts[4], texts[5], name, extent, tail)


def _parse_extent(kind: str, texts: List[str]) -> Tuple[Optional[Extent], int]:
    """Returns the extent, and the number of remaining `texts` for the tail."""
    if len(texts) < 4:
        if needs_extent(kind):
            raise FieldError(f'{kind} with {len(texts)} corner coordinates', 'from, to',
                             'four whole numbers in mm')
        return None, len(texts)
    try:
        return Extent(*map(parse_integer, texts[:4], _EXTENT_FIELDS)), len(texts) - 4
    except FieldError:
        if needs_extent(kind):
            raise
        return None, len(texts)  # an unknown kind is kept as it is


def parse_decimal(text: str, field: str) -> float:
    """Returns a finite decimal number; raises FieldError."""
    value = float(text) if _DECIMAL.fullmatch(text) else math.nan
    if not abs(value) <= _LARGEST:
        raise FieldError(f'{printable(text)!r} is wrong', field, 'a finite decimal number')
    return value


def parse_integer(text: str, field: str) -> int:
    """Returns a whole number of 32 bits; raises FieldError."""
    if not _INTEGER.fullmatch(text) or len(text) > 11 or abs(int(text)) > _LARGEST:
        raise FieldError(f'{printable(text)!r} is wrong', field, 'a whole number')
    return int(text)


def format_object(obj: MapObject) -> str:
    """Returns the `Cairn:` line of `obj` in the form of the vendor's tools, without a line end.

    Raises FieldError for a value that the format does not support.
    """
    for field in ('kind', 'icon'):
        text = getattr(obj, field)
        if not re.fullmatch(r'[^\s"]+', text):
            raise FieldError(f'{text!r}', field, 'one word without quotes')
    if not obj.name and (obj.is_goal or obj.is_dock):
        raise FieldError('the name is empty', 'name',
                         f'a name, because {obj.kind} is a driving target')
    for field in ('x', 'y', 'theta'):
        if not abs(getattr(obj, field)) <= _LARGEST:
            raise FieldError(f'{getattr(obj, field)!r}', field, 'a finite number')
    words = ['Cairn:', obj.kind, str(round(obj.x)), str(round(obj.y)),
             f'{round(obj.theta, 6) + 0.0:.6f}', quoted(obj.description, 'description'), obj.icon,
             quoted(obj.name, 'name')]
    if obj.extent is not None:
        corners = dataclasses.astuple(obj.extent)
        if max(map(abs, corners)) > _LARGEST:
            raise FieldError(f'{corners} is too far away', 'from, to', 'coordinates of 32 bits')
        words += map(str, corners)
    words += obj.tail
    line = ' '.join(words)
    if len(encode(line)) + 2 >= MAX_LINE_BYTES:
        raise FieldError(f'a line of {len(line)} characters', 'Cairn',
                         f'less than {MAX_LINE_BYTES} bytes')
    if len(words) > MAX_LINE_WORDS:
        raise FieldError(f'a line of {len(words)} words', 'Cairn', f'at most {MAX_LINE_WORDS}')
    return line
