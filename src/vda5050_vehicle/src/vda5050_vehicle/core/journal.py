"""The journal: the state for a restart as a log, with one line of JSON per change of the state.

Keys of a change:
- whole value: `=` the new value
- record: `~` the changes of its fields
- table: `+` the new or changed entries, `-` the removed entries
- sequence: `<` number of items removed at the start, `keep` number of items kept after that,
  `+` the items after these
"""
from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from typing import Any, Dict, Iterable, Mapping, Optional, Tuple, Type

from json_records import from_json, to_json
from vda5050_vehicle.core.state import VdaVehicleState
from vda5050_vehicle.drivers.driver import DriveProgress

VERSION = 4


class WrongRecord(Exception):
    """A journal that cannot be used; the text gives the reason."""


def line(before: Optional[VdaVehicleState], now: VdaVehicleState, boot: str = '') -> str:
    """Returns the line with the changes; with the whole state if `before` is None.

    boot -- id of the computer's boot
    """
    return json.dumps({'version': VERSION, 'boot': boot, '=': to_json(now)} if before is None
                      else _change(before, now))


def boot_of(first: str) -> str:
    """Returns the id of the boot in which the first line of a valid journal was written."""
    return str(json.loads(first).get('boot'))


def read(lines: Iterable[str], drive: Type[DriveProgress]) -> VdaVehicleState:
    """Returns the state after all lines; raises WrongRecord.

    drive -- the class of the driver's memory
    """
    value: Any = None
    try:
        for number, text in enumerate(lines):
            change = json.loads(text)
            if number == 0 and change.get('version') != VERSION:
                raise WrongRecord(f'it is of version {change.get("version")}, not {VERSION}')
            value = _changed(value, change)
        return from_json(VdaVehicleState, value, instead={'drive': drive})
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
        kept = [key for key in before if key in now]
        if list(now)[:len(kept)] == kept:  # the new entries come after the kept entries
            return _table_change(before, now)
    if isinstance(now, tuple) and isinstance(before, tuple):
        return _sequence_change(before, now)
    return {'=': to_json(now)}


def _table_change(before: Mapping[str, Any], now: Mapping[str, Any]) -> Dict[str, Any]:
    return {'+': {key: to_json(item) for key, item in now.items() if before.get(key) is not item},
            '-': [key for key in before if key not in now]}


def _sequence_change(before: Tuple[Any, ...], now: Tuple[Any, ...]) -> Dict[str, Any]:
    begin = len(before) - len(now)
    if begin > 0 and before[begin:] == now:
        return {'<': begin, 'keep': len(now), '+': []}
    keep = next((i for i, (old, new) in enumerate(zip(before, now)) if old != new),
                min(len(before), len(now)))
    return {'<': 0, 'keep': keep, '+': [to_json(item) for item in now[keep:]]}


def _differ(before: Any, now: Any) -> bool:
    return before is not now and before != now


def _changed(value: Any, change: Mapping[str, Any]) -> Any:
    """Returns the JSON of a value after a change."""
    if '=' in change:
        return change['=']
    if '~' in change:
        return {**value, **{key: _changed(value[key], item) for key, item in change['~'].items()}}
    if '-' in change:
        return {**{key: item for key, item in value.items() if key not in change['-']},
                **change['+']}
    kept = value[change['<']:]
    return kept[:change['keep']] + change['+']
