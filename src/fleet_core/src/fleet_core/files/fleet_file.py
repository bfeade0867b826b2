"""The fleet file: one YAML file that lists the robots for all programs.

    clearance: 0.1                # m between any two robots
    dock_approach: 2.0            # m before a dock that a docking robot blocks (optional)
    robot_types:
    - {name: agv, radius: 0.4, speed: 1.0}
    - {name: truck, radius: 0.6, speed: 1.35, play: 0.25, obeys_edge_speed: false, docks: [16]}
    robots:
    - {name: agv_1, type: agv, vertex: 8, driver: agv}  # the driver is optional
    - {name: agv_2, type: agv, vertex: 9, absent: true}  # in repair, or not delivered yet

Other programs read other keys of the file. A key that no program reads is an error.
"""
from __future__ import annotations

import math
import os
from typing import Dict, Union

import yaml

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_keys import check_keys
from fleet_core.files.strict_fields import named
from fleet_core.fleet import DOCK_APPROACH, Fleet, Robot, RobotType
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

_LARGEST = 1e4  # m and m/s: a larger number is a mistake


def load_fleet(path: Union[str, os.PathLike]) -> Fleet:
    """Returns the fleet in a file; raises FileError."""
    try:
        root = strict_yaml.compose(path)
        check_keys(root)
        fields = strict_yaml.mapping(root, 'the file')
        clearance = _length(strict_yaml.field(fields, 'clearance', root))
        approach = strict_yaml.optional(fields, 'dock_approach', _length, DOCK_APPROACH)
        types = named(strict_yaml.field(fields, 'robot_types', root), 'robot type', _robot_type)
        if not types:
            raise WrongYaml('robot_types is empty; describe at least one', fields['robot_types'])

        def robot(name: str, node: yaml.Node, fields: Dict[str, yaml.Node]) -> Robot:
            kind = strict_yaml.text(strict_yaml.field(fields, 'type', node))
            if kind not in types:
                raise WrongYaml(f'robot {name}: there is no robot type {kind!r}; '
                                f'there are: {", ".join(types)}', fields['type'])
            return Robot(name, types[kind],
                         strict_yaml.whole(strict_yaml.field(fields, 'vertex', node)),
                         strict_yaml.optional(fields, 'driver', strict_yaml.text, ''),
                         strict_yaml.optional(fields, 'absent', strict_yaml.truth, False))
        robots = named(strict_yaml.field(fields, 'robots', root), 'robot', robot)
        return Fleet(tuple(types.values()), tuple(robots.values()), clearance, approach)
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def _robot_type(name: str, node: yaml.Node, fields: Dict[str, yaml.Node]) -> RobotType:
    docks = strict_yaml.optional(fields, 'docks', strict_yaml.listed(strict_yaml.whole), None)
    return RobotType(
        name,
        _positive(strict_yaml.field(fields, 'radius', node)),
        _positive(strict_yaml.field(fields, 'speed', node)),
        strict_yaml.optional(fields, 'play', _length, 0.0),
        strict_yaml.optional(fields, 'obeys_edge_speed', strict_yaml.truth, True),
        None if docks is None else frozenset(docks))


def _length(field: Field) -> float:
    value = strict_yaml.real(field)
    if not (math.isfinite(value) and 0.0 <= value <= _LARGEST):
        raise WrongYaml(f'{field[0]} is {value}, but must be a number from 0 to {_LARGEST:.0f}',
                        field[1])
    return value


def _positive(field: Field) -> float:
    value = _length(field)
    if value == 0.0:
        raise WrongYaml(f'{field[0]} is 0, but must be more', field[1])
    return value
