"""What a restarted vehicle must know, as a log: one line of JSON for each change of its state.

A value is written whole as `=`, a record as the changes of its fields `~`, a table as the entries
that changed `+` and went `-`, a sequence as how much of its beginning went `<`, how much of the
rest stayed `keep`, and what came behind that `+`.
"""
from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache
from typing import (
    Any,
    Dict,
    FrozenSet,
    Iterable,
    Mapping,
    Optional,
    Type,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from vda5050_vehicle.core.state import VehicleState
from vda5050_vehicle.drivers.driver import Drive

VERSION = 3
_PLAIN: FrozenSet[type] = frozenset({str, int, float, bool})


class WrongRecord(Exception):
    """A journal that cannot be used; the text says why."""


def line(before: Optional[VehicleState], now: VehicleState) -> str:
    """What changed; all of it where nothing was stored before."""
    change = {'=': _json(now)} if before is None else _change(before, now)
    return json.dumps({'version': VERSION, **change} if before is None else change)


def read(lines: Iterable[str], drive: Type[Drive]) -> VehicleState:
    """The state after all lines; `drive` is what the driver remembers. Raises WrongRecord."""
    value: Any = None
    try:
        for number, text in enumerate(lines):
            change = json.loads(text)
            if number == 0 and change.get('version') != VERSION:
                raise WrongRecord(f'it is of version {change.get("version")}, not {VERSION}')
            value = _changed(value, change)
        state: VehicleState = _value(VehicleState, value, {'drive': drive})
        return state
    except (AttributeError, KeyError, IndexError, TypeError, ValueError,
            RecursionError) as error:
        raise WrongRecord(f'{type(error).__name__}: {error}') from None


# --- changes --------------------------------------------------------------------------------------

def _change(before: Any, now: Any) -> Dict[str, Any]:
    if is_dataclass(now) and type(before) is type(now):
        return {'~': {field.name: _change(getattr(before, field.name), getattr(now, field.name))
                      for field in fields(now)
                      if _differ(getattr(before, field.name), getattr(now, field.name))}}
    if isinstance(now, dict) and isinstance(before, dict):
        gone = [key for key in before if key not in now]
        new = {key: item for key, item in now.items() if before.get(key) is not item}
        kept = [key for key in before if key in now]
        if list(now)[:len(kept)] == kept:  # what came is behind what stayed
            return {'+': {key: _json(item) for key, item in new.items()}, '-': gone}
    if isinstance(now, tuple) and isinstance(before, tuple):
        begin = len(before) - len(now)
        if begin > 0 and before[begin:] == now:
            return {'<': begin, 'keep': len(now), '+': []}
        keep = next((i for i, (old, new) in enumerate(zip(before, now)) if old != new),
                    min(len(before), len(now)))
        return {'<': 0, 'keep': keep, '+': [_json(item) for item in now[keep:]]}
    return {'=': _json(now)}


def _differ(before: Any, now: Any) -> bool:
    return before is not now and before != now


def _changed(value: Any, change: Mapping[str, Any]) -> Any:
    """The JSON of a value after a change of it."""
    if '=' in change:
        return change['=']
    if '~' in change:
        return {**value, **{key: _changed(value[key], item) for key, item in change['~'].items()}}
    if '-' in change:
        return {**{key: item for key, item in value.items() if key not in change['-']},
                **change['+']}
    kept = value[change['<']:]
    return kept[:change['keep']] + change['+']


# --- values ---------------------------------------------------------------------------------------

def _json(value: Any) -> Any:
    if is_dataclass(value):
        return {field.name: _json(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, dict):
        return {key: _json(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_json(item) for item in value]
    return value


@lru_cache(maxsize=None)
def _hints(kind: type) -> Dict[str, Any]:
    return get_type_hints(kind)


def _value(kind: Any, found: Any, instead: Mapping[str, type]) -> Any:
    """The value of a type that some JSON means; `instead` names types of fields that are narrower
    than what the class says. Raises TypeError, ValueError, KeyError."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is Any:
        return found
    if origin is Union:  # Optional
        return None if found is None else _value(arguments[0], found, {})
    if origin is tuple:
        return tuple(_value(arguments[0], item, {}) if arguments[1] is ...
                     else _value(arguments[index], item, {}) for index, item in enumerate(found))
    if origin is not None:
        return {key: _value(arguments[1], item, {}) for key, item in found.items()}
    if is_dataclass(kind):
        make: Any = kind
        hints = {**_hints(make), **instead}
        if set(found) != {field.name for field in fields(make)}:
            raise ValueError(f'{make.__name__} has other fields than {sorted(found)}')
        return make(**{name: _value(hints[name], item, {}) for name, item in found.items()})
    if kind in _PLAIN:
        if not isinstance(found, (int, float) if kind is float else kind):
            raise TypeError(f'{found!r:.40} is no {kind.__name__}')
        return found
    return kind(found)  # an enum
