"""The scan header: the file's values about the points and lines of each scan source.

In a file with several scans each key begins with the name of its source, without a separator. A key
without a name belongs to the first source: the vendor omits the name for `SickLaser`.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Sequence, Tuple

from omron_map.errors import FieldError
from omron_map.objects import parse_integer
from omron_map.text import printable
from omron_map.tokens import Token

CATEGORIES = ('2D-Map', '2D-Map-Ex', '2D-Map-Ex2', '2D-Map-Ex3', '2D-Map-Ex4')


def _text(words: Sequence[Token], key: str) -> str:
    return ' '.join(word.text for word in words)


def _integers(count: int, least: int) -> Callable[[Sequence[Token], str], Any]:
    def parse(words: Sequence[Token], key: str) -> Any:
        expected = 'one whole number' if count == 1 else f'{count} whole numbers'
        if len(words) != count:
            raise FieldError(f'{printable(_text(words, key))!r} is wrong', key, expected)
        values = tuple(parse_integer(word.text, key) for word in words)
        if min(values) < least:
            raise FieldError(f'{min(values)} is too small', key, f'{least} or more')
        return values if count > 1 else values[0]
    return parse


def _truth(words: Sequence[Token], key: str) -> bool:
    text = words[0].text.lower() if len(words) == 1 else ''
    if text not in ('true', '1', 'false', '0'):
        raise FieldError(f'{printable(_text(words, key))!r} is wrong', key, 'true or false')
    return text in ('true', '1')


_COORDINATES = _integers(2, least=-2**31)
_COUNT = _integers(1, least=0)

#: Every key of a scan's header, in the vendor's order, and the reader of its value.
SCAN_KEYS: Dict[str, Callable[[Sequence[Token], str], Any]] = {
    'Display': _text,
    'MinPos': _COORDINATES,
    'MaxPos': _COORDINATES,
    'NumPoints': _COUNT,
    'PointsAreSorted': _truth,
    'Resolution': _integers(1, least=-1),
    'LineMinPos': _COORDINATES,
    'LineMaxPos': _COORDINATES,
    'NumLines': _COUNT,
    'LinesAreSorted': _truth,
}


_SUFFIXES = tuple(f'{key}:'.lower() for key in SCAN_KEYS)
_OTHER_KEYS = tuple(category.lower() for category in CATEGORIES) + (
    'sources:', 'originlatlongalt:', 'originlatlonalt:')  # the last key occurs in a public map


def is_header(keyword: str) -> bool:
    """Returns whether a line with this first word (lower case) belongs to the file's header."""
    return keyword.endswith(_SUFFIXES) or keyword in _OTHER_KEYS


@dataclass
class ScanHeader:
    """The header's values about one scan source, and their lines, by key."""

    source: str
    values: Dict[str, Any] = field(default_factory=dict)
    lines: Dict[str, int] = field(default_factory=dict)


def scan_keys(sources: Sequence[str]) -> Dict[str, Tuple[str, str]]:
    """Returns the source and the key for each possible first word (lower case) of a header line."""
    meanings = {f'{key}:'.lower(): (sources[0], key) for key in SCAN_KEYS}
    for source in reversed(sources):
        meanings.update((f'{source}{key}:'.lower(), (source, key)) for key in SCAN_KEYS)
    return meanings


def parse_sources(words: Sequence[Token]) -> List[str]:
    """Returns the names in the `Sources:` line; raises FieldError if a name is repeated."""
    names = [word.text for word in words]
    lowered = [name.lower() for name in names]
    for name in names:
        if lowered.count(name.lower()) > 1:
            raise FieldError(f'{printable(name)!r} is given twice', 'Sources',
                             'a different name for each scan')
    return names
