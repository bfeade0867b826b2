"""The LINES and DATA sections: rows of whole millimetres, read in bulk and strictly."""
from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np

from omron_map.errors import FieldError
from omron_map.text import decode

MAX_BOX = 2_000_000  # mm; the vendor's library refuses a larger box
COLUMNS = {'DATA': ('x', 'y'), 'LINES': ('x1', 'y1', 'x2', 'y2')}

_HEADING = re.compile(rb'(?:(\S+)_)?(LINES|DATA)', re.IGNORECASE)
_NUMBER = re.compile(rb'-?[0-9]+')


@dataclass(frozen=True)
class Section:
    """One section: the original bytes of its keyword line and rows, and the rows as numbers."""

    heading: bytes
    body: bytes
    source: str
    kind: str
    rows: np.ndarray

    @property
    def raw(self) -> bytes:
        """The bytes of the section in the file."""
        return self.heading + self.body

    def with_final(self, line_end: bytes) -> Section:
        """Returns the same section with a line end behind its last row."""
        if not self.body:
            return dataclasses.replace(self, heading=self.heading + line_end)
        return dataclasses.replace(self, body=self.body + line_end)


def is_heading(line: bytes) -> bool:
    """Returns whether a line begins a section, like `DATA` or `Laser_1_LINES`."""
    return _HEADING.fullmatch(line.strip()) is not None


def split_sections(data: bytes, line: int) -> List[Section]:
    """Returns the sections of `data`, which begins with a section keyword.

    line -- line number of the beginning of `data` in the file
    Raises FieldError, with the line, in these cases:
    - a row is not a row of numbers, or has a wrong number of values
    - rows are too far apart
    - there is metadata after the first section; the vendor's library would drop it
    """
    starts = _heading_offsets(data, line)
    sections = []
    for start, end in zip(starts, starts[1:] + [len(data)]):
        head = data.find(b'\n', start, end) + 1 or end
        heading = _HEADING.fullmatch(data[start:head].strip())
        assert heading is not None, 'a section begins where a heading is'
        kind = heading.group(2).decode().upper()
        body = data[head:end]
        line += 1
        source = decode(heading.group(1) or b'')
        sections.append(Section(data[start:head], body, source, kind,
                                parse_rows(body, COLUMNS[kind], line)))
        line += body.count(b'\n')
    return sections


def _heading_offsets(data: bytes, line: int) -> List[int]:
    """Returns the offsets of the section keywords: only they have letters, rows do not."""
    letters = np.flatnonzero(np.frombuffer(data, np.uint8) > ord('9'))
    offsets: List[int] = []
    read_to = 0
    while True:
        at = np.searchsorted(letters, read_to)
        if at == len(letters):
            return offsets
        start = data.rfind(b'\n', 0, letters[at]) + 1
        read_to = data.find(b'\n', start) + 1 or len(data)
        text = data[start:read_to].strip()
        if is_heading(text):
            offsets.append(start)
        elif re.match(rb'\S*:', text):
            key = text.split(b':')[0][:40].decode('utf-8', 'replace')
            raise FieldError(f'{key + ":"!r} is after the first section', 'section',
                             'all metadata before the first LINES or DATA',
                             line + data.count(b'\n', 0, start))
        else:
            return offsets  # a wrong row; parse_rows reports it in detail


def parse_rows(body: bytes, columns: tuple, line: int) -> np.ndarray:
    """Returns the rows in `body` as an int32 array (N, len(columns)); raises FieldError.

    line -- line number of the first row
    """
    rows = _parse_plain_rows(body, len(columns))
    if rows is None:
        rows = _parse_odd_rows(body, columns, line)
    if len(rows):
        low, high = bounds(rows)
        if max(high[0] - low[0], high[1] - low[1]) > MAX_BOX:
            raise FieldError(f'the rows reach from {low} to {high} mm', 'section',
                             f'at most {MAX_BOX // 1_000_000} km each way',
                             _line_of_row(body, _far_row(rows), line))
    return rows.astype(np.int32)


def _parse_plain_rows(body: bytes, columns: int) -> Optional[np.ndarray]:
    """Returns the rows if all have one blank between numbers, as in the vendor's tools; else None.

    Four checks of the whole block ensure that it contains only such rows:
    - the separators alternate
    - each minus begins a number
    - there are as many numbers as separators
    - no number is too large
    """
    body = body.replace(b'\r\n', b'\n') if b'\r' in body else body
    if body and not body.endswith(b'\n'):
        body += b'\n'
    separators = body.translate(None, b'-0123456789')
    count = len(separators) // columns
    if separators != (b' ' * (columns - 1) + b'\n') * count:
        return None
    text = np.frombuffer(b'\n' + body, np.uint8)
    minus = text[1:-1] == ord('-')
    if np.any(minus & ((text[:-2] > ord(' ')) | (text[2:] < ord('0')))):
        return None
    numbers = np.fromstring(body, np.int64, sep=' ')
    if len(numbers) != count * columns or np.any(np.abs(numbers) >= 2**31):
        return None
    return numbers.reshape(count, columns)


def _parse_odd_rows(body: bytes, columns: tuple, line: int) -> np.ndarray:
    """Returns rows with any white space between numbers and with blank lines; raises FieldError."""
    rows = []
    for number, raw in enumerate(body.split(b'\n'), line):
        words = raw.split()
        for word, column in zip(words, columns):
            if not _NUMBER.fullmatch(word) or abs(int(word[:12])) >= 2**31:
                raise FieldError(f'{word[:40].decode("utf-8", "replace")!r} is wrong', column,
                                 'a whole number of mm', number)
        if words and len(words) != len(columns):
            cut = number == line + body.count(b'\n') and not body.endswith(b'\n')
            raise FieldError('the file ends inside a row' if cut
                             else f'{len(words)} values are wrong', 'row',
                             f'{len(columns)}: {" ".join(columns)}', number)
        rows += [int(word) for word in words]
    return np.array(rows, np.int64).reshape(-1, len(columns))


def bounds(rows: np.ndarray) -> Tuple[Tuple[int, int], Tuple[int, int]]:
    """Returns the lowest and highest x, y of the points or line ends in `rows` (one or more)."""
    # Column by column: numpy is slow along an axis of length two.
    low = [min(int(rows[:, i].min()) for i in range(axis, rows.shape[1], 2)) for axis in (0, 1)]
    high = [max(int(rows[:, i].max()) for i in range(axis, rows.shape[1], 2)) for axis in (0, 1)]
    return (low[0], low[1]), (high[0], high[1])


def sorted_rows(rows: np.ndarray, once: bool = False) -> np.ndarray:
    """Returns `rows` sorted by their columns from first to last.

    once -- whether equal rows are returned only once
    """
    rows = rows[np.lexsort(rows.T[::-1])]
    if not once:
        return rows
    new = np.ones(len(rows), bool)
    new[1:] = np.any(rows[1:] != rows[:-1], axis=1)
    return rows[new]


def _far_row(rows: np.ndarray) -> int:
    """Returns the index of the row that is farthest from the others."""
    return int(np.abs(rows - np.median(rows, axis=0)).max(axis=1).argmax())


def _line_of_row(body: bytes, row: int, line: int) -> int:
    return [number for number, raw in enumerate(body.split(b'\n'), line) if raw.strip()][row]
