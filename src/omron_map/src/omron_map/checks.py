"""Finds strange entries in a map that do not prevent its use, and returns them as warnings."""
from __future__ import annotations

from typing import Dict, Iterator, List, Sequence, Set, Tuple

import numpy as np

from omron_map.errors import FieldError, MapWarning
from omron_map.objects import name_key
from omron_map.reader import BOM, Record
from omron_map.references import find_references
from omron_map.scans import Scan
from omron_map.sections import Section, bounds
from omron_map.text import printable
from omron_map.tokens import tokenise


def check(records: Sequence[Record], sections: Sequence[Section],
          scans: Sequence[Scan]) -> List[MapWarning]:
    """Returns all warnings about a map; `records` are its metadata lines, from line 1 on."""
    return [*_encoding(records, sections), *_header(scans), *_names(records), *_tails(records),
            *_declarations(records), *_dangling(records)]


def _encoding(records: Sequence[Record], sections: Sequence[Section]) -> Iterator[MapWarning]:
    if records[0].raw.startswith(BOM):
        yield MapWarning("the file begins with a byte order mark: the vendor's tools refuse it", 1)
    if not sections[-1].raw.endswith(b'\n'):
        yield MapWarning("the last row has no line end: the vendor's tools ignore this row")


def _header(scans: Sequence[Scan]) -> Iterator[MapWarning]:
    for scan in scans:
        for keys, rows in ((('NumPoints', 'MinPos', 'MaxPos', 'PointsAreSorted'), scan.points),
                           (('NumLines', 'LineMinPos', 'LineMaxPos', 'LinesAreSorted'),
                            scan.lines)):
            yield from _claims(scan, keys, rows)


def _claims(scan: Scan, keys: Tuple[str, ...], rows: np.ndarray) -> Iterator[MapWarning]:
    """Yields a warning for each header value that contradicts `rows`; readers use the rows."""
    count, low, high, ordered = keys
    found: Dict[str, object] = {count: len(rows)}
    if len(rows):
        found[low], found[high] = bounds(rows)
    for key, value in found.items():
        claim = scan.header.values.get(key)
        if claim is not None and claim != value:
            yield MapWarning(f'{scan.name}{key} says {_show(claim)}, the rows say {_show(value)}',
                             scan.header.lines[key])
    if scan.header.values.get(ordered) and not _is_sorted(rows):
        yield MapWarning(f'{scan.name}{ordered} says true, but the rows are not sorted',
                         scan.header.lines[ordered])


def _show(value: object) -> str:
    return ' '.join(map(str, value)) if isinstance(value, tuple) else str(value)


def _is_sorted(rows: np.ndarray) -> bool:
    """Returns whether the rows are sorted by their first column, then by the next ones."""
    undecided = np.ones(max(len(rows) - 1, 0), bool)
    for column in rows.T:
        if np.any(undecided & (column[1:] < column[:-1])):
            return False
        undecided &= column[1:] == column[:-1]
    return True


def _names(records: Sequence[Record]) -> Iterator[MapWarning]:
    first: Dict[str, int] = {}
    for number, record in enumerate(records, 1):
        if record.object is None or not record.object.name:
            continue
        name = record.object.key
        if name in first:
            yield MapWarning(f'{record.object} has the name of the '
                             f'object in line {first[name]}: only that object is found', number)
        first.setdefault(name, number)


def _tails(records: Sequence[Record]) -> Iterator[MapWarning]:
    for number, record in enumerate(records, 1):
        obj = record.object
        if obj is None or not obj.tail:
            continue
        if obj.polygon is None:
            yield MapWarning(f'{obj} ends with words of unknown meaning: '
                             'they are kept', number)
        elif obj.theta != 0.0:
            yield MapWarning(f'{obj} is a rotated polygon: '
                             'its rectangle is drawn instead', number)


def _declarations(records: Sequence[Record]) -> Iterator[MapWarning]:
    """Yields a warning for each goal whose type is not declared, if the file declares goal types.

    The same applies to docks and dock types.
    """
    declared = _declared_types(records)
    for number, record in enumerate(records, 1):
        obj = record.object
        if obj is None or not (obj.is_goal or obj.is_dock):
            continue
        declaration = 'docktype' if obj.is_dock else 'goaltype'
        if declared[declaration] and obj.base_kind not in declared[declaration]:
            yield MapWarning(f'{obj}: the map declares other types, but not '
                             f'this one (MapInfo: {"DockType" if obj.is_dock else "GoalType"} '
                             f'Name={obj.base_kind})', number)


def _declared_types(records: Sequence[Record]) -> Dict[str, Set[str]]:
    """Returns the names of the declared types of goals and docks."""
    declared: Dict[str, Set[str]] = {'goaltype': set(), 'docktype': set()}
    for record in records:
        if record.keyword == 'mapinfo:':
            try:
                words = [word.text for word in tokenise(record.text)]
            except FieldError:
                continue
            if len(words) > 1 and words[1].lower() in declared:
                declared[words[1].lower()].update(
                    word[len('Name='):] for word in words if word.startswith('Name='))
    return declared


def _dangling(records: Sequence[Record]) -> Iterator[MapWarning]:
    present = set()
    for record in records:
        if record.object is not None:
            present.add(record.object.key)
        elif record.keyword in ('_cairn:', 'childcairn:'):
            try:
                present.update(name_key(word.text) for word in tokenise(record.text)[7:8])
            except FieldError:
                continue
    for number, record in enumerate(records, 1):
        for reference in find_references(record.keyword, record.text):
            if name_key(reference.token.text) not in present:
                yield MapWarning(f'{record.text.split(None, 1)[0]} names '
                                 f'{printable(reference.token.text)!r}, which is not in the map',
                                 number)
