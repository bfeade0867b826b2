"""Edits of a map's objects: which lines change, and where new ones go.

An edit changes the object's `Cairn:` line and, where its name changes, the lines that name it. The
order is the vendor's: by stored position, then kind, then name. `file` is what errors call the map.
"""
from __future__ import annotations

import dataclasses
import math
from typing import List, Optional, Tuple

from omron_ld90.maps.errors import DuplicateName, FieldError, MapError
from omron_ld90.maps.geometry import Extent, normalise_degrees
from omron_ld90.maps.header import is_header
from omron_ld90.maps.objects import MapObject, format_object
from omron_ld90.maps.reader import Record
from omron_ld90.maps.references import find_references

#: A line that an edit left alone, and what is to be said about it.
Note = Tuple[Record, str]


def add(file: str, records: List[Record], obj: MapObject) -> None:
    """Insert `obj` in the vendor's order."""
    _refuse_duplicate(file, records, obj.name)
    record = _record(file, records, obj)
    records.insert(_place(records, obj), record)


def remove(file: str, records: List[Record], obj: MapObject) -> List[Note]:
    """Take out `obj` and its parameters; tell which lines still name it."""
    del records[_index(file, records, obj)]
    if not obj.name or find(records, obj.name) is not None:
        return []
    owned = [record for record in records
             if any(ref.owned for ref in find_references(record.keyword, record.text, obj.name))]
    for record in owned:
        records.remove(record)
    return _mentions(records, obj.name, f'still names {obj.label!r}, which was removed')


def move(file: str, records: List[Record], obj: MapObject, x: float, y: float,
         theta: Optional[float]) -> None:
    """Place `obj` elsewhere."""
    index = _index(file, records, obj)
    if obj.tail:
        raise MapError(file, f'{obj.kind} {obj.label!r} has more than corners and cannot '
                       'be moved; remove it and add a new one', index + 1)
    if not all(math.isfinite(value) for value in (x, y, theta or 0.0)):
        raise MapError(file, f'{obj.kind} {obj.label!r} cannot be moved to {x}, {y}, '
                       f'{theta}', index + 1, expected='finite numbers')
    moved = _moved(obj, x, y, obj.theta if theta is None else normalise_degrees(theta))
    _replace(records, index, _record(file, records, moved))


def _replace(records: List[Record], index: int, record: Record) -> None:
    """Put `record` in the place of another: where it belongs, if the objects are in order."""
    if _sorted(records):
        del records[index]
        records.insert(_place(records, record.object), record)
    else:
        records[index] = record


def _moved(obj: MapObject, x: float, y: float, theta: float) -> MapObject:
    if obj.is_area:
        rectangle = dataclasses.replace(obj.rectangle, centre_x=x, centre_y=y, yaw=theta)
        return dataclasses.replace(obj, theta=theta, extent=rectangle.to_extent())
    if obj.extent is not None:
        old = obj.extent
        right, up = round(x) - old.from_x, round(y) - old.from_y
        extent = Extent(old.from_x + right, old.from_y + up, old.to_x + right, old.to_y + up)
        return dataclasses.replace(obj, x=extent.from_x, y=extent.from_y, extent=extent)
    return dataclasses.replace(obj, x=x, y=y, theta=theta if obj.has_heading else 0.0)


def rename(file: str, records: List[Record], obj: MapObject,
           new_name: str) -> List[Note]:
    """Change the name of `obj` and of the references that surely mean it."""
    index = _index(file, records, obj)
    if not new_name:
        raise MapError(file, f'{obj.kind} {obj.label!r} cannot lose its name', index + 1)
    if new_name.lower() != obj.name.lower():
        _refuse_duplicate(file, records, new_name)
    renamed = dataclasses.replace(obj, name=new_name)
    _replace(records, index, _record(file, records, renamed))
    if not obj.name or find(records, obj.name) not in (None, renamed):
        return []  # another object has the old name too, and keeps what names it
    for position, record in enumerate(records):
        records[position] = _with_new_reference(record, obj.name, new_name)
    if new_name.lower() == obj.name.lower():
        return []
    return _mentions(records, obj.name, f'still names {obj.label!r}, now {new_name!r}')


def _with_new_reference(record: Record, name: str, new_name: str) -> Record:
    """`record` with only the bytes of the sure references changed."""
    text = record.raw.decode('utf-8', 'surrogateescape')
    for ref in reversed(find_references(record.keyword, record.text, name)):
        if ref.certain:
            text = f'{text[:ref.token.start]}"{new_name}"{text[ref.token.end:]}'
    return record._replace(raw=text.encode('utf-8', 'surrogateescape'))


def _mentions(records: List[Record], name: str, text: str) -> List[Note]:
    """The lines that may or may not mean the object `name`."""
    return [(record, f'{record.text.split(None, 1)[0]} {text}') for record in records
            if any(not ref.certain for ref in find_references(record.keyword, record.text, name))]


def find(records: List[Record], name: str) -> Optional[MapObject]:
    """The first object called `name`, upper or lower case, or None."""
    wanted = name.lower()
    return next((record.object for record in records
                 if record.object is not None and record.object.name.lower() == wanted), None)


def _index(file: str, records: List[Record], obj: MapObject) -> int:
    """Where `obj` is: itself, else the first that is equal to it."""
    for same in (lambda other: other is obj, lambda other: other == obj):
        for index, record in enumerate(records):
            if record.object is not None and same(record.object):
                return index
    raise MapError(file, f'{obj.kind} {obj.label!r} is not in the map')


def _refuse_duplicate(file: str, records: List[Record], name: str) -> None:
    other = find(records, name) if name else None
    if other is not None:
        raise DuplicateName(
            file, f'there is a {other.kind} {other.label!r} already', field='name',
            expected='a name of its own, upper and lower case being the same')


def _record(file: str, records: List[Record], obj: MapObject) -> Record:
    try:
        text = format_object(obj)
    except FieldError as error:
        raise error.in_file(file) from None
    return Record(text.encode('utf-8', 'surrogateescape') + line_end(records), 'cairn:', obj)


def line_end(records: List[Record]) -> bytes:
    """The file's own line end."""
    return b'\r\n' if records[0].raw.endswith(b'\r\n') else b'\n'


def _sorted(records: List[Record]) -> bool:
    anchors = [record.object.anchor for record in records if record.object is not None]
    return all(a <= b for a, b in zip(anchors, anchors[1:]))


def _place(records: List[Record], obj: MapObject) -> int:
    """Index at which the record of `obj` belongs."""
    present = [index for index, record in enumerate(records) if record.object is not None]
    if not present:
        return _after_info(records)
    if _sorted(records):
        for index in present:
            if records[index].object.order > obj.order:
                return index
    return present[-1] + 1


def _after_info(records: List[Record]) -> int:
    """Behind the header and the active info lines, ahead of all that may follow."""
    places = [index + 1 for index, record in enumerate(records)
              if is_header(record.keyword)
              or (record.keyword.endswith('info:') and not record.keyword.startswith('_'))]
    return places[-1]
