"""Reads the special kinds of parameters of this node: levels of MQTT topics, and YAML files."""
from __future__ import annotations

from typing import Any

import rospy
import yaml

from node_lifecycle import ConfigurationError, parameter


def topic_level(name: str, default: str) -> str:
    """Returns a parameter that is one level of an MQTT topic; raises ConfigurationError."""
    value: str = parameter(name, default)
    if not value or not value.isprintable() or set(value) & set('/+#$'):
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value!r}, but must be '
                                 'one level of an MQTT topic: not empty, without / + # and $.')
    return value


def yaml_file(path: str, what: str) -> Any:
    """Returns the contents of a YAML file; raises ConfigurationError."""
    try:
        with open(path, encoding='utf-8') as file:
            return yaml.safe_load(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ConfigurationError(f'{what} {path} cannot be read: {error}') from None
