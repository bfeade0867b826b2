"""Edits of a map's points and lines: they change only the rows and the header's values about them.

Rows are sorted, as in the vendor's tools. Points are written without repetitions. If there are no
rows of a kind, their header keys and the LINES section are removed. Only maps with a single scan
that has no name can be edited.
"""
from __future__ import annotations

from typing import List, Optional

import numpy as np

from omron_map.errors import FieldError
from omron_map.header import SCAN_KEYS
from omron_map.reader import Record
from omron_map.sections import COLUMNS, Section, bounds, parse_rows, sorted_rows

#: Header keys about the rows of each kind of section: lowest and highest corner, count, sorted.
ROW_KEYS = {
    'DATA': ('MinPos', 'MaxPos', 'NumPoints', 'PointsAreSorted'),
    'LINES': ('LineMinPos', 'LineMaxPos', 'NumLines', 'LinesAreSorted'),
}
_ORDER = list(SCAN_KEYS)


def checked_rows(rows: object, kind: str) -> np.ndarray:
    """Returns `rows` in their written form; raises FieldError if they are not whole mm of 32 bits.
    """
    columns = len(COLUMNS[kind])
    array = np.asarray(rows, float)
    if not array.size:
        array = np.empty((0, columns))
    if array.ndim != 2 or array.shape[1] != columns or not np.all(array == np.rint(array)):
        raise FieldError(f'an array of shape {array.shape} is not an array of rows', kind,
                         f'(N, {columns}) whole numbers of mm')
    if np.any(np.abs(array) >= 2**31):
        raise FieldError('a coordinate is too large', kind, 'whole numbers of 32 bits')
    return sorted_rows(array.astype(np.int64), once=kind == 'DATA')


def with_rows(sections: List[Section], kind: str, rows: np.ndarray, line_end: bytes
              ) -> List[Section]:
    """Returns `sections` with one section of `rows` in place of all sections of `kind`."""
    end = line_end.decode()
    body = ''.join(' '.join(map(str, row)) + end for row in rows.tolist()).encode()
    places = [index for index, section in enumerate(sections) if section.kind == kind]
    heading = sections[places[0]].heading if places else kind.encode() + line_end
    if not heading.endswith(b'\n'):
        heading += line_end
    section = Section(heading, body, '', kind, parse_rows(body, COLUMNS[kind], 1))
    place = places[0] if places else (0 if kind == 'LINES' else len(sections))
    others = [section for section in sections if section.kind != kind]
    wanted = kind == 'DATA' or len(rows) or not others
    return others[:place] + ([section] if wanted else []) + others[place:]


def update_header(records: List[Record], kind: str, rows: np.ndarray, line_end: bytes) -> None:
    """Updates the header lines about `rows` in `records`; a correct line stays as it is."""
    values: List[Optional[str]] = [None] * 4
    if len(rows):
        low, high = bounds(rows)
        values = [f'{low[0]} {low[1]}', f'{high[0]} {high[1]}', str(len(rows)), 'true']
    for key, value in zip(ROW_KEYS[kind], values):
        places = [i for i, record in enumerate(records) if record.keyword == f'{key}:'.lower()]
        if value is None:
            for place in reversed(places):
                del records[place]
        elif not places:
            record = Record(f'{key}: {value}'.encode() + line_end, f'{key}:'.lower())
            records.insert(_place(records, key), record)
        else:
            old = records[places[-1]]
            keyword, *words = old.text.split()
            if words != value.split() and not (value == 'true' and words == ['1']):
                records[places[-1]] = old._replace(raw=f'{keyword} {value}'.encode() + line_end)


def _place(records: List[Record], key: str) -> int:
    """Returns the index for a new key, in the vendor's order of the keys.

    The new key follows the last present key that the vendor's tools write before it. If there is
    none, it follows the category.
    """
    earlier = {f'{name}:'.lower() for name in _ORDER[:_ORDER.index(key)]}
    places = [index + 1 for index, record in enumerate(records) if record.keyword in earlier]
    if places:
        return places[-1]
    return next(index for index, record in enumerate(records) if record.keyword) + 1
