"""Parameters are read strictly: a missing or wrong one is one sentence that says what to do."""
from __future__ import annotations

import math
from typing import Any, Type

import rospy

REQUIRED = object()


class ConfigurationError(Exception):
    """A parameter or file that the node cannot work with; the text says which and what to do."""


def parameter(name: str, default: Any = REQUIRED, kind: Type = str) -> Any:
    """The parameter `name` as `kind`, an int also for a float; raises ConfigurationError."""
    resolved = rospy.resolve_name(name)
    value = rospy.get_param(name, default)
    if value is REQUIRED:
        raise ConfigurationError(f'Parameter {resolved} is missing: set it in the launch file.')
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise ConfigurationError(
            f'Parameter {resolved} is {value!r}, but must be of type {kind.__name__}.')
    return value


def number(name: str, default: float, least: float = -math.inf, most: float = math.inf) -> float:
    """A number within `least`..`most`; raises ConfigurationError."""
    value = parameter(name, default, float)
    if not least <= value <= most:
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value}, but must lie '
                                 f'in {least}..{most}.')
    return value
