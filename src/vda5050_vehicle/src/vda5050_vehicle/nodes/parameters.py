"""Parameters of this node's own kinds."""
from __future__ import annotations

from typing import Any

import rospy
import yaml

from node_lifecycle import ConfigurationError, parameter


def topic_level(name: str, default: str) -> str:
    """A text that is one level of an MQTT topic; raises ConfigurationError."""
    value: str = parameter(name, default)
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
