"""Converts dataclasses to JSON and back, with a check of every type, for all stored data.

A dataclass becomes an object; a NamedTuple or tuple becomes a list; an enum becomes its value.
Annotations may be dataclasses, NamedTuples, enums, str, int, float, bool, Any, and Optional, Tuple,
List and Mapping of these.
"""
from __future__ import annotations

from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache
from typing import (
    Any,
    Container,
    Dict,
    FrozenSet,
    List,
    Mapping,
    Tuple,
    Type,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

Kind = TypeVar('Kind')

_PLAIN: FrozenSet[type] = frozenset({str, int, float, bool})


def to_json(value: Any) -> Any:
    """Converts a value to types that JSON has."""
    if is_dataclass(value):
        return {field.name: to_json(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, dict):
        return {key: to_json(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [to_json(item) for item in value]
    return value


def from_json(kind: Type[Kind], found: Any, added: Container[str] = (),
              instead: Mapping[str, type] = {}) -> Kind:
    """Returns the value of type `kind` that `to_json` has converted to `found`.

    added   -- fields of dataclasses that older versions did not write; they get their defaults
    instead -- narrower types for fields of `kind`; they replace the annotations of these fields

    Raises TypeError or ValueError.
    """
    value: Kind = _Reader(added).value(kind, found, instead)
    return value


class _Reader:
    def __init__(self, added: Container[str]) -> None:
        self._added = added

    def value(self, kind: Any, found: Any, instead: Mapping[str, type] = {}) -> Any:
        if kind is Any:
            return found
        origin, arguments = get_origin(kind), get_args(kind)
        if origin is Union:  # Optional
            return None if found is None else self.value(arguments[0], found)
        if origin is tuple:
            return self._tuple(arguments, _checked(list, found))
        if origin is list:
            return [self.value(arguments[0], item) for item in _checked(list, found)]
        if origin is not None:
            return {key: self.value(arguments[1], item)
                    for key, item in _checked(dict, found).items()}
        if is_dataclass(kind):
            return self._record(kind, _checked(dict, found), instead)
        if issubclass(kind, tuple):  # a NamedTuple
            return kind(*self._tuple(tuple(_hints(kind).values()), _checked(list, found)))
        if kind in _PLAIN:
            return _checked((int, float) if kind is float else kind, found)
        return kind(found)  # an enum

    def _tuple(self, kinds: Tuple[Any, ...], found: List[Any]) -> Tuple[Any, ...]:
        if kinds[1:] == (...,):
            return tuple(self.value(kinds[0], item) for item in found)
        if len(found) != len(kinds):
            raise ValueError(f'{found!r:.80} has not {len(kinds)} items')
        return tuple(map(self.value, kinds, found))

    def _record(self, kind: Any, found: Dict[str, Any], instead: Mapping[str, type]) -> Any:
        hints = {**_hints(kind), **instead}
        names = {field.name for field in fields(kind)}
        wrong = [name for name in names ^ set(found)
                 if name in found or name not in self._added]
        if wrong:
            raise ValueError(f'{kind.__name__} has other fields than {sorted(found)!s:.200}')
        return kind(**{name: self.value(hints[name], item) for name, item in found.items()})


def _checked(kind: Any, found: Any) -> Any:
    if not isinstance(found, kind):
        raise TypeError(f'{found!r:.40} is not of type {getattr(kind, "__name__", "float")}')
    return found


@lru_cache(maxsize=None)
def _hints(kind: type) -> Dict[str, Any]:
    return get_type_hints(kind)
