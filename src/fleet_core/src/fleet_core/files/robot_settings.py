"""The settings of robots in the fleet file that `path_supervisor` reads, per type or per robot.

    robot_types:
    - {name: truck, ..., release_ahead: 8.0, slack: 0.3, charge_below: 0.3, leave_above: 0.8}
    robots:
    - {name: truck_1, type: truck, vertex: 8, charge_below: 0.4}

A setting of a robot overrides the setting of its type. RobotSettings explains each setting.
"""
from __future__ import annotations

import math
import os
from dataclasses import fields
from typing import Dict, Mapping, Union

import yaml

from fleet_core.files.errors import FileError
from fleet_core.supervision.settings import RobotSettings
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import WrongYaml

_SHARES = ('charge_below', 'leave_above', 'idle_below', 'reserve')  # fractions of a full battery
_KEYS = tuple(field.name for field in fields(RobotSettings))


def load_settings(path: Union[str, os.PathLike]) -> Dict[str, RobotSettings]:
    """Returns the settings of every robot in a fleet file; raises FileError."""
    try:
        root = strict_yaml.compose(path)
        whole = strict_yaml.mapping(root, 'the file')
        types: Dict[str, Dict[str, float]] = {}
        for node in strict_yaml.items(strict_yaml.field(whole, 'robot_types', root)):
            entry = strict_yaml.mapping(node, 'an entry of robot_types')
            name = strict_yaml.text(strict_yaml.field(entry, 'name', node))
            types[name] = _numbers(entry)
        found: Dict[str, RobotSettings] = {}
        for node in strict_yaml.items(strict_yaml.field(whole, 'robots', root)):
            entry = strict_yaml.mapping(node, 'an entry of robots')
            name = strict_yaml.text(strict_yaml.field(entry, 'name', node))
            kind = strict_yaml.text(strict_yaml.field(entry, 'type', node))
            settings = RobotSettings(**{**types.get(kind, {}), **_numbers(entry)})
            if settings.leave_above < settings.charge_below:
                raise WrongYaml(f'robot {name}: leave_above is less than charge_below', node)
            if settings.leave_above < settings.idle_below:
                raise WrongYaml(f'robot {name}: leave_above is less than idle_below', node)
            found[name] = settings
        return found
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def _numbers(entry: Mapping[str, yaml.Node]) -> Dict[str, float]:
    found: Dict[str, float] = {}
    for key in _KEYS:
        if key in entry:
            value = strict_yaml.real((key, entry[key]))
            most = 1.0 if key in _SHARES else 1e7
            if not (math.isfinite(value) and 0.0 <= value <= most):
                raise WrongYaml(f'{key} is {value}, but must be a number from 0 to {most:g}',
                                entry[key])
            found[key] = value
    return found
