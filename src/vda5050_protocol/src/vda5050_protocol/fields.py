"""The elements of the codecs' tables: kinds of JSON values, and records of named fields.

A kind converts JSON to a value and back. Reading checks each known key strictly and ignores
unknown keys. An optional key with the value null counts as absent, because some serialisers write
null for a member without a value. A message may contain incomplete, infinite or too long values, or
values of a wrong type; the error names the path of the wrong value.
"""
from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from enum import Enum
from operator import attrgetter
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Type, Union

MAX_MESSAGE = 1_000_000  # bytes
MAX_TEXT = 1_000         # characters
MAX_ARRAY = 2_000        # elements
MAX_DEPTH = 20           # levels of nesting of a free JSON value
UINT32 = 2 ** 32 - 1


class Malformed(Exception):
    """A message that cannot be read; `path` is the wrong value, e.g. `nodes[1].sequenceId`."""

    def __init__(self, path: str, problem: str) -> None:
        super().__init__(f'{path or "the message"} {problem}')
        self.path = path
        self.problem = problem


class Kind:
    """A kind of JSON value."""

    def read(self, value: Any, path: str) -> Any:
        """Converts JSON to a value; raises Malformed."""
        raise NotImplementedError

    def write(self, value: Any) -> Any:
        """Converts a value to JSON."""
        return value


class TextKind(Kind):
    """A string of printable characters."""

    def read(self, value: Any, path: str) -> str:
        """See Kind."""
        if not isinstance(value, str):
            raise Malformed(path, f'is {_name(value)}, but must be a string')
        if len(value) > MAX_TEXT:
            raise Malformed(path, f'has {len(value)} characters; at most {MAX_TEXT} are allowed')
        if not all(char.isprintable() or char in '\n\t' for char in value):
            raise Malformed(path, 'has control characters')
        return value


@dataclass(frozen=True)
class Number(Kind):
    """A finite number from `least` to `most`, both included."""

    least: float = -math.inf
    most: float = math.inf

    def read(self, value: Any, path: str) -> float:
        """See Kind."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise Malformed(path, f'is {_name(value)}, but must be a number')
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number) or not self.least <= number <= self.most:
            raise Malformed(path, f'is {str(value)[:30]}, but must lie in '
                                  f'{self.least:g}..{self.most:g}')
        return number

    def write(self, value: float) -> float:
        """See Kind; rounds to six decimals: a micrometre, a microradian."""
        return round(value, 6)


class UnsignedInteger(Kind):
    """An integer from 0 to 2**32 - 1; accepts 7.0, because JSON has no integer type."""

    def read(self, value: Any, path: str) -> int:
        """See Kind."""
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise Malformed(path, f'is {_name(value)}, but must be an integer')
        if not 0 <= value <= UINT32:
            raise Malformed(path, f'is {str(value)[:30]}, but must lie in 0..{UINT32}')
        return value


class Boolean(Kind):
    """True or false."""

    def read(self, value: Any, path: str) -> bool:
        """See Kind."""
        if not isinstance(value, bool):
            raise Malformed(path, f'is {_name(value)}, but must be true or false')
        return value


@dataclass(frozen=True)
class Choice(Kind):
    """The name of a member of an enum.

    spelling -- members that this version of the standard spells differently
    unknown  -- members that this version does not have
    """

    enum: Type[Enum]
    spelling: Tuple[Tuple[Enum, str], ...] = ()
    unknown: Tuple[Enum, ...] = ()

    def read(self, value: Any, path: str) -> Enum:
        """See Kind."""
        known = {self.write(member): member for member in self.enum if member not in self.unknown}
        if isinstance(value, str) and value in known:
            return known[value]
        raise Malformed(path, f'is {str(value)[:40]!r}, but must be one of {", ".join(known)}')

    def write(self, value: Enum) -> str:
        """See Kind."""
        return dict(self.spelling).get(value, value.value)


class Anything(Kind):
    """Any JSON value with at most MAX_DEPTH levels of nesting."""

    def read(self, value: Any, path: str) -> Any:
        """See Kind."""
        if _depth(value) > MAX_DEPTH:
            raise Malformed(path, f'is nested more than {MAX_DEPTH} levels deep')
        return value


class Object(Anything):
    """Any JSON object with at most MAX_DEPTH levels of nesting."""

    def read(self, value: Any, path: str) -> Any:
        """See Kind."""
        if not isinstance(value, dict):
            raise Malformed(path, f'is {_name(value)}, but must be an object')
        return super().read(value, path)


@dataclass(frozen=True)
class ListOf(Kind):
    """An array of values of one kind; a tuple in Python."""

    kind: Kind

    def read(self, value: Any, path: str) -> Tuple:
        """See Kind."""
        if not isinstance(value, list):
            raise Malformed(path, f'is {_name(value)}, but must be an array')
        if len(value) > MAX_ARRAY:
            raise Malformed(path, f'has {len(value)} elements; at most {MAX_ARRAY} are allowed')
        return tuple(self.kind.read(item, f'{path}[{i}]') for i, item in enumerate(value))

    def write(self, value: Sequence) -> list:
        """See Kind."""
        return [self.kind.write(item) for item in value]


TEXT, NUMBER, UINT, BOOLEAN = TextKind(), Number(), UnsignedInteger(), Boolean()
ANYTHING, OBJECT = Anything(), Object()


@dataclass(frozen=True)
class Field:
    """One line of a table.

    attribute -- the attribute in Python; `a.b` is only allowed in a field that is never read
    key       -- the key in JSON
    kind      -- the kind of the value
    required  -- whether a message without this field is malformed
    aliases   -- other keys that masters use for this field
    omitted   -- the value for which the field is not written
    """

    attribute: str
    key: str
    kind: Kind
    required: bool = False
    aliases: Tuple[str, ...] = ()
    omitted: Any = None

    def find(self, json_object: Mapping[str, Any]) -> Tuple[Optional[str], Any]:
        """Returns the key and the value of this field in the object; None, None if absent."""
        present = [key for key in (self.key, *self.aliases) if key in json_object]
        key = next((key for key in present if json_object[key] is not None),
                   present[0] if present else None)
        return (None, None) if key is None else (key, json_object[key])


class ObjectKind(Kind):
    """A JSON object that represents a dataclass, described by a table of fields."""

    def __init__(self, kind: type, fields: Sequence[Field]) -> None:
        self.kind = kind
        self.fields = tuple(fields)

    def field(self, key: str) -> Optional[Field]:
        """Returns the field with this JSON key; None if there is none."""
        return next((field for field in self.fields if field.key == key), None)

    def field_of(self, attribute: str) -> Optional[Field]:
        """Returns the field of this attribute; None if there is none."""
        return next((field for field in self.fields if field.attribute == attribute), None)

    def read(self, value: Any, path: str) -> Any:
        """See Kind."""
        if not isinstance(value, dict):
            raise Malformed(path, f'is {_name(value)}, but must be an object')
        found: Dict[str, Any] = {}
        for field in self.fields:
            key, item = field.find(value)
            if key is None:
                if field.required:
                    raise Malformed(_join(path, field.key), 'is missing')
            elif item is not None or field.required:
                found[field.attribute] = field.kind.read(item, _join(path, key))
        return self.kind(**found)

    def write(self, value: Any) -> Dict[str, Any]:
        """See Kind."""
        result: Dict[str, Any] = {}
        for field in self.fields:
            item = attrgetter(field.attribute)(value)
            if field.required or (item is not None and item != field.omitted):
                result[field.key] = field.kind.write(item)
        return result

    def changed(self, **fields: Union[Field, None]) -> ObjectKind:
        """Returns the table with the lines of these attributes replaced; None removes a line."""
        table = [fields.get(field.attribute, field) for field in self.fields]
        known = {field.attribute for field in self.fields}
        added = [field for name, field in fields.items() if name not in known]
        return ObjectKind(self.kind, [field for field in (*table, *added) if field is not None])

    def renamed(self, **keys: str) -> ObjectKind:
        """Returns the table with other JSON keys for these attributes."""
        return ObjectKind(self.kind, [replace(field, key=keys.get(field.attribute, field.key))
                                      for field in self.fields])


def read_json(payload: bytes) -> Dict[str, Any]:
    """Returns the JSON object in a payload; raises Malformed."""
    if len(payload) > MAX_MESSAGE:
        raise Malformed('', f'has {len(payload)} bytes; at most {MAX_MESSAGE} are allowed')
    try:
        value = json.loads(payload.decode('utf-8'), parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise Malformed('', f'is not JSON in UTF-8: {str(error)[:80]}') from None
    if not isinstance(value, dict):
        raise Malformed('', f'is {_name(value)}, but must be an object')
    return value


def write_json(value: Mapping[str, Any]) -> bytes:
    """Returns the payload of a JSON object."""
    return json.dumps(value, separators=(',', ':'), allow_nan=False).encode()


def _no_constant(name: str) -> None:
    raise ValueError(f'{name} is not a JSON number')


def _join(path: str, key: str) -> str:
    return f'{path}.{key}' if path else key


def _name(value: Any) -> str:
    names = {dict: 'an object', list: 'an array', str: 'a string', bool: 'true or false',
             type(None): 'null'}
    return names.get(type(value), 'a number')


def _depth(value: Any) -> int:
    depth, level = 0, [value]
    while level and depth <= MAX_DEPTH:
        level = [inner for item in level if isinstance(item, (dict, list))
                 for inner in (item.values() if isinstance(item, dict) else item)]
        depth += 1
    return depth
