"""All keys of a fleet file that any program reads. Another key in the file is an error.

Without this check a misspelt `play` or `slack` would silently be 0.
"""
from __future__ import annotations

from dataclasses import fields
from typing import Sequence

import yaml

from fleet_core.files.strict_fields import meant
from fleet_core.supervision.settings import RobotSettings
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import WrongYaml

_SETTINGS = tuple(field.name for field in fields(RobotSettings))
_FILE = ('clearance', 'dock_approach', 'robot_types', 'robots')
_TYPE = ('name', 'radius', 'speed', 'play', 'obeys_edge_speed', 'docks', *_SETTINGS)
_ROBOT = ('name', 'type', 'vertex', 'driver', 'absent', 'start', 'host', 'arcl_port',
          'outgoing_port', 'password_file', 'computer', *_SETTINGS)
_IGNORED = ('stopping',)  # fleet files of version 1.0.0 have this key


def check_keys(root: yaml.Node) -> None:
    """Raises WrongYaml for a key of a fleet file that no program reads."""
    whole = strict_yaml.mapping(root, 'the file')
    _check(root, 'the file', _FILE)
    for name, what, known in (('robot_types', 'a robot type', _TYPE),
                              ('robots', 'a robot', _ROBOT)):
        if name in whole:
            for node in strict_yaml.items((name, whole[name])):
                _check(node, what, known)


def _check(node: yaml.Node, what: str, known: Sequence[str]) -> None:
    for key in strict_yaml.mapping(node, what, known):
        if key not in (*known, *_IGNORED):
            line = next(name for name, _ in node.value if name.value == key)
            raise WrongYaml(f'{what} has a key {key!r} that no program reads; '
                            f'{meant(key, known)}', line)
