"""Edits of a map's objects: the lines that change, and the positions of new lines.

An edit changes the object's `Cairn:` line. If the name changes, it also changes the lines that name
the object. The lines are sorted as in the vendor's tools: by stored position, then kind, then name.
In all functions `file` is the name of the map in errors.
"""
from __future__ import annotations

import dataclasses
import math
from typing import Dict, Iterable, List, Mapping, Optional, Tuple

from omron_map.errors import DuplicateName, FieldError, MapError
from omron_map.geometry import Extent, normalise_degrees
from omron_map.header import is_header
from omron_map.objects import MapObject, format_object, name_key
from omron_map.reader import Record
from omron_map.references import find_references, may_name_objects
from omron_map.text import decode, encode

#: A line that an edit did not change, and the text of the warning about it.
Note = Tuple[Record, str]


def add(file: str, records: List[Record], objects: Iterable[MapObject]) -> None:
    """Inserts `objects` in the vendor's order: all of them, or none if one is refused."""
    known = _by_name(records)
    added = []
    for obj in objects:
        _refuse_duplicate(file, known, obj.name)
        added.append(_record(file, records, obj))
        known.setdefault(obj.key, obj)
    _insert(records, added)


def remove(file: str, records: List[Record], objects: Iterable[MapObject]) -> List[Note]:
    """Removes `objects` and their parameters, all or none.

    Returns the lines that still name them.
    """
    gone = set(_indices(file, records, objects))
    removed = [records[index] for index in sorted(gone)]
    records[:] = [record for index, record in enumerate(records) if index not in gone]
    left = _by_name(records)
    naming = [record for record in records if may_name_objects(record.keyword)]
    kept = naming
    notes: List[Note] = []
    for key, obj in _by_name(removed).items():
        if obj.name and key not in left:
            kept = [record for record in kept if not _is_parameter_of(obj.name, record)]
            notes += _mentions(kept, obj.name, f'still names {obj.label!r}, which was removed')
    owned = {id(record) for record in naming} - {id(record) for record in kept}
    records[:] = [record for record in records if id(record) not in owned]
    return notes


def _is_parameter_of(name: str, record: Record) -> bool:
    """Returns whether a line is a parameter of the object `name`, and is removed with the object.
    """
    return any(ref.owned for ref in find_references(record.keyword, record.text, name))


def move(file: str, records: List[Record], obj: MapObject, x: float, y: float,
         theta: Optional[float]) -> None:
    """Moves `obj` to x, y (mm) and theta (degrees; None keeps it)."""
    index, = _indices(file, records, [obj])
    if obj.tail:
        raise MapError(file, f'{obj} has words after its corners and cannot '
                       'be moved; remove it and add a new one', index + 1)
    if not all(math.isfinite(value) for value in (x, y, theta or 0.0)):
        raise MapError(file, f'{obj} cannot be moved to {x}, {y}, '
                       f'{theta}', index + 1, expected='finite numbers')
    moved = _moved(obj, x, y, obj.theta if theta is None else normalise_degrees(theta))
    _replace(records, index, _record(file, records, moved))


def _replace(records: List[Record], index: int, record: Record) -> None:
    """Replaces a record; if the objects are sorted, the new record is inserted in order."""
    if _sorted(records):
        del records[index]
        _insert(records, [record])
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
    """Changes the name of `obj` and of the references that certainly mean it."""
    index, = _indices(file, records, [obj])
    if not new_name:
        raise MapError(file, f'{obj} cannot lose its name', index + 1)
    if name_key(new_name) != obj.key:
        _refuse_duplicate(file, _by_name(records), new_name)
    renamed = dataclasses.replace(obj, name=new_name)
    _replace(records, index, _record(file, records, renamed))
    if not obj.name or find(records, obj.name) not in (None, renamed):
        return []  # another object also has the old name, and the references mean that object
    for position, record in enumerate(records):
        records[position] = _with_new_reference(record, obj.name, new_name)
    if name_key(new_name) == obj.key:
        return []
    return _mentions(records, obj.name, f'still names {obj.label!r}, now {new_name!r}')


def _with_new_reference(record: Record, name: str, new_name: str) -> Record:
    """Returns `record` with the new name in those references that are certain."""
    text = decode(record.raw)
    for ref in reversed(find_references(record.keyword, record.text, name)):
        if ref.certain:
            text = f'{text[:ref.token.start]}"{new_name}"{text[ref.token.end:]}'
    return record._replace(raw=encode(text))


def _mentions(records: List[Record], name: str, text: str) -> List[Note]:
    """Returns a note with `text` for each line that perhaps names the object `name`."""
    return [(record, f'{record.text.split(None, 1)[0]} {text}') for record in records
            if any(not ref.certain for ref in find_references(record.keyword, record.text, name))]


def find(records: List[Record], name: str) -> Optional[MapObject]:
    """Returns the first object with this name, without regard to case, or None."""
    return _by_name(records).get(name_key(name))


def _by_name(records: List[Record]) -> Dict[str, MapObject]:
    """Returns the first object of each name, by its key."""
    found: Dict[str, MapObject] = {}
    for record in records:
        if record.object is not None:
            found.setdefault(record.object.key, record.object)
    return found


def _indices(file: str, records: List[Record], objects: Iterable[MapObject]) -> List[int]:
    """Returns for each object the index of its record.

    If no record has the identical object, this is the first record with an equal object. No index
    is returned twice. Raises MapError for an object that is not in the map.
    """
    places: Dict[MapObject, List[int]] = {}
    for index, record in enumerate(records):
        if record.object is not None:
            places.setdefault(record.object, []).append(index)
    found = []
    for obj in objects:
        equal = places.get(obj)
        if not equal:
            raise MapError(file, f'{obj} is not in the map')
        found.append(next((index for index in equal if records[index].object is obj), equal[0]))
        equal.remove(found[-1])
    return found


def _refuse_duplicate(file: str, known: Mapping[str, MapObject], name: str) -> None:
    other = known.get(name_key(name)) if name else None
    if other is not None:
        raise DuplicateName(
            file, f'there is a {other} already', field='name',
            expected='a name that no other object has, without regard to case')


def _record(file: str, records: List[Record], obj: MapObject) -> Record:
    try:
        text = format_object(obj)
    except FieldError as error:
        raise error.in_file(file) from None
    return Record(encode(text) + line_end(records), 'cairn:', obj)


def line_end(records: List[Record]) -> bytes:
    """Returns the line end that the file uses."""
    return b'\r\n' if records[0].raw.endswith(b'\r\n') else b'\n'


def _sorted(records: List[Record]) -> bool:
    anchors = [record.object.anchor for record in records if record.object is not None]
    return all(a <= b for a, b in zip(anchors, anchors[1:]))


def _insert(records: List[Record], added: List[Record]) -> None:
    """Inserts the records of new objects in order; at the end if the objects are not sorted."""
    present = [index for index, record in enumerate(records) if record.object is not None]
    if not _sorted(records):
        end = present[-1] + 1
        records[end:end] = added
        return
    end = present[-1] + 1 if present else _after_info(records)
    waiting = sorted(added, key=_order)[::-1]
    merged: List[Record] = []
    for record in records[:end]:
        if record.object is not None:
            while waiting and _order(waiting[-1]) < _order(record):
                merged.append(waiting.pop())
        merged.append(record)
    records[:end] = merged + waiting[::-1]


def _order(record: Record) -> Tuple:
    """Returns the sort key of a line that is an object."""
    assert record.object is not None
    return record.object.order


def _after_info(records: List[Record]) -> int:
    """Returns the index after the header and the active info lines."""
    places = [index + 1 for index, record in enumerate(records)
              if is_header(record.keyword)
              or (record.keyword.endswith('info:') and not record.keyword.startswith('_'))]
    return places[-1]
