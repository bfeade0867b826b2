"""The robots of a fleet file that have their own computer, and so their own ROS master.

    robots:
    - {name: ld90_1, type: ld90, vertex: 16, driver: ld90, computer: 10.0.0.5}
"""
from __future__ import annotations

import os
import re
from ipaddress import AddressValueError, IPv4Address
from typing import Dict, Union

from fleet_core.files.errors import FileError
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

_HOST_NAME = re.compile(r'[A-Za-z0-9]([A-Za-z0-9.-]{0,252})\Z')


def load_computers(path: Union[str, os.PathLike]) -> Dict[str, str]:
    """Returns the address of each robot's own computer, by the robot's name; raises FileError."""
    try:
        root = strict_yaml.compose(path)
        whole = strict_yaml.mapping(root, 'the file')
        found: Dict[str, str] = {}
        for node in strict_yaml.items(strict_yaml.field(whole, 'robots', root)):
            robot = strict_yaml.mapping(node, 'an entry of robots')
            if 'computer' in robot:
                name = strict_yaml.text(strict_yaml.field(robot, 'name', node))
                found[name] = computer(('computer', robot['computer']))
        return found
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def computer(one: Field) -> str:
    """Returns the address of a computer in a fleet file; raises WrongYaml."""
    address = strict_yaml.text(one)
    if not is_address(address):
        raise WrongYaml(f'{one[0]} is {address!r}, but must be the IPv4 address or the name of a '
                        'computer', one[1])
    return address


def is_address(text: str) -> bool:
    """Returns whether the text is an IPv4 address or a valid name of a computer."""
    if not text.replace('.', '').isdigit():
        return bool(_HOST_NAME.match(text))
    try:
        IPv4Address(text)
    except AddressValueError:
        return False
    return True
