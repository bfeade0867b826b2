"""Reads parameters strictly. If one is missing or wrong, the error says what to do."""
from __future__ import annotations

import math
from typing import Any, Tuple, Type

import rospy

from node_lifecycle.kept_parameters import KEPT

REQUIRED = object()
NOT_THERE = object()


class ConfigurationError(Exception):
    """A parameter or file cannot be used. The text says which one, and what to do."""


def parameter(name: str, default: Any = REQUIRED, kind: Type = str) -> Any:
    """Returns the parameter `name` (e.g. `~robot_ip`) as `kind`; raises ConfigurationError.

    The type must match, with two exceptions: a whole number is accepted as a float; a number is
    accepted as a text, because roslaunch turns `password:=1234` into a number. A required text must
    not be empty, and a float must be finite.
    """
    where = f'Parameter {rospy.resolve_name(name)}'
    value = rospy.get_param(name, NOT_THERE)
    if value is NOT_THERE:
        value = default
    else:
        KEPT.keep(rospy.resolve_name(name), value)
    if value is REQUIRED or (default is REQUIRED and value == ''):
        raise ConfigurationError(f'{where} is missing: set it in the launch file.')
    try:
        return _as_kind(value, kind)
    except TypeError as error:
        raise ConfigurationError(f'{where} is {value!r}, but must be {error}.') from None


def _as_kind(value: Any, kind: Type) -> Any:
    """Returns the value as `kind`. Raises TypeError with a text about the required form."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and kind is str:
        return str(value)
    if kind is float:
        if is_number and math.isfinite(value):
            return float(value)
        raise TypeError('a finite number')
    if not isinstance(value, kind) or (kind is int and not is_number):
        raise TypeError(f'of type {kind.__name__}')
    return value


def number(name: str, default: float, minimum: float = -math.inf,
           maximum: float = math.inf) -> float:
    """Returns a float parameter within `minimum`..`maximum`; raises ConfigurationError."""
    value: float = parameter(name, default, float)
    if not minimum <= value <= maximum:
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value}, but must lie '
                                 f'in {minimum}..{maximum}.')
    return value


def choice(name: str, default: str, allowed: Tuple[str, ...]) -> str:
    """Returns a text parameter that must be one of `allowed`; raises ConfigurationError."""
    value: str = parameter(name, default)
    if value not in allowed:
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value!r}, but must be '
                                 f'one of {", ".join(allowed)}.')
    return value
