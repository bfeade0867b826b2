"""Parameters are read strictly: a missing or wrong one is one sentence that says what to do."""
from __future__ import annotations

import math
from typing import Any, Tuple, Type

import rospy
import yaml

REQUIRED = object()


class ConfigurationError(Exception):
    """A parameter or file that the node cannot work with; the text says which and what to do."""


def parameter(name: str, default: Any = REQUIRED, kind: Type = str) -> Any:
    """The parameter `name` as `kind`; raises ConfigurationError.

    Numbers will do for a string, as roslaunch makes one of `serial_number:=0001`.
    """
    resolved = rospy.resolve_name(name)
    value = rospy.get_param(name, default)
    if value is REQUIRED:
        raise ConfigurationError(f'Parameter {resolved} is missing: set it in the launch file.')
    if kind is str and isinstance(value, (int, float)) and not isinstance(value, bool):
        return str(value)
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


def choice(name: str, default: str, allowed: Tuple[str, ...]) -> str:
    """A text that must be one of `allowed`; raises ConfigurationError."""
    value = parameter(name, default)
    if value not in allowed:
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value!r}, but must be '
                                 f'one of {", ".join(allowed)}.')
    return value


def topic_level(name: str, default: str) -> str:
    """A text that is one level of an MQTT topic; raises ConfigurationError."""
    value = parameter(name, default)
    if not value or not value.isprintable() or set(value) & set('/+#$'):
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value!r}, but is a '
                                 'level of MQTT topics: not empty, and without / + # and $.')
    return value


def yaml_file(path: str, what: str) -> Any:
    """What a YAML file holds; raises ConfigurationError."""
    try:
        with open(path, encoding='utf-8') as file:
            return yaml.safe_load(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ConfigurationError(f'{what} {path} cannot be read: {error}') from None
