"""The missions file of `plan_fleet`: the vertices that each robot must visit, in order.

    missions:
    - {robot: agv_1, vertices: [18, 39, 52]}
"""
from __future__ import annotations

import os
from typing import Dict, Tuple, Union

from fleet_core.files.errors import FileError
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import WrongYaml


def load_missions(path: Union[str, os.PathLike]) -> Dict[str, Tuple[int, ...]]:
    """Returns the vertices to visit, by the robot's name. Raises FileError."""
    found: Dict[str, Tuple[int, ...]] = {}
    try:
        root = strict_yaml.compose(path)
        fields = strict_yaml.mapping(root, 'the file')
        for node in strict_yaml.items(strict_yaml.field(fields, 'missions', root)):
            entry = strict_yaml.mapping(node, 'an entry of missions')
            robot = strict_yaml.text(strict_yaml.field(entry, 'robot', node))
            if robot in found:
                raise WrongYaml(f'robot {robot} has two missions; put all its vertices into one',
                                node)
            found[robot] = tuple(strict_yaml.listed(strict_yaml.whole)(
                strict_yaml.field(entry, 'vertices', node)))
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None
    return found
