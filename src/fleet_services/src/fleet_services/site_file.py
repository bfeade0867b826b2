"""The site file, which describes the services of a fleet on this computer.

    name: hall                 # part of the units' names: fleet-hall-manager.service ...
    user: fleet                # a user without privileges; created if it does not exist
    address: 10.0.0.9          # address of this computer for robots' computers; default: 127.0.0.1
    master_port: 11311
    robots_per_unit: 10        # largest number of LD-90s whose nodes share a unit
    networks: [10.0.0.0/24]    # networks with which the services may communicate; default: all
    arguments:                 # arguments of scripts/run.sh fleet:=...; paths relative to this file
      fleet: fleet.yaml
      graph_file: graph.yaml
      map_file: site.map
      token_file: tokens
      listen: 10.0.0.9
"""
from __future__ import annotations

import os
import re
from dataclasses import dataclass
from ipaddress import ip_network
from typing import List, Tuple

import yaml

from fleet_bringup.options import Options, parse
from fleet_bringup.robot_entries import tcp_port
from fleet_core.files.errors import FileError
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

KEYS = ('name', 'user', 'address', 'master_port', 'robots_per_unit', 'networks', 'arguments')
_NAME = re.compile(r'[a-z][a-z0-9-]{0,30}\Z')
_ADDRESS = re.compile(r'[0-9A-Za-z.:-]+\Z')
#: Arguments that are paths or can be paths.
_FILES = ('fleet', 'graph_file', 'work_file', 'base_map', 'map_file', 'token_file',
          'certificate_file', 'key_file')
#: Arguments that need a screen.
_NOT_HERE = ('rviz',)


@dataclass(frozen=True)
class SiteFile:
    """The content of a site file. The paths in `options` are absolute."""

    name: str
    options: Options
    user: str = 'fleet'
    address: str = '127.0.0.1'
    master_port: int = 11311
    robots_per_unit: int = 10
    networks: Tuple[str, ...] = ()
    path: str = ''

    @property
    def sources(self) -> Tuple[str, ...]:
        """The site file, and the files that its arguments name."""
        given = (self.path, *(getattr(self.options, name) for name in _FILES))
        return tuple(path for path in given if path.startswith('/'))


def read_site(path: str) -> SiteFile:
    """Reads a site file; raises FileError, and CannotStart for wrong arguments."""
    try:
        root = strict_yaml.compose(path)
        given = strict_yaml.mapping(root, 'the file', KEYS)
        for key, value in given.items():
            if key not in KEYS:
                raise WrongYaml(f'there is no key {key!r}; there are: {", ".join(KEYS)}', value)
        words = _words(strict_yaml.field(given, 'arguments', root))
        return SiteFile(
            name=_name(strict_yaml.field(given, 'name', root)),
            options=parse([*words, 'rviz:=false'], os.path.dirname(path)),
            user=strict_yaml.optional(given, 'user', _name, 'fleet'),
            address=strict_yaml.optional(given, 'address', _address, '127.0.0.1'),
            master_port=strict_yaml.optional(given, 'master_port', tcp_port, 11311),
            robots_per_unit=strict_yaml.optional(given, 'robots_per_unit', _count, 10),
            networks=strict_yaml.optional(given, 'networks', _networks, ()),
            path=os.path.abspath(path))
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def site_name(text: str) -> str:
    """Checks the name of a site or of a user, which becomes part of paths; raises WrongYaml."""
    if not _NAME.match(text):
        raise WrongYaml(f'"{text}" must begin with a small letter and have only small letters, '
                        'digits and "-", 31 at most')
    return text


def _words(one: Field) -> List[str]:
    """Returns the arguments as `name:=value`."""
    words = []
    for name, node in strict_yaml.mapping(one[1], 'arguments').items():
        if name in _NOT_HERE:
            raise WrongYaml(f'{name} cannot be used in a service: remove it', node)
        if not isinstance(node, yaml.ScalarNode):
            raise WrongYaml(f'{name} must be one value', node)
        words.append(f'{name}:={node.value}')
    return words


def _name(one: Field) -> str:
    try:
        return site_name(strict_yaml.text(one))
    except WrongYaml as wrong:
        raise WrongYaml(f'{one[0]} {wrong.problem}', one[1]) from None


def _address(one: Field) -> str:
    address = strict_yaml.text(one)
    if not _ADDRESS.match(address):
        raise WrongYaml(f'{one[0]} "{address}" is not the address or name of a computer', one[1])
    return address


def _networks(one: Field) -> Tuple[str, ...]:
    texts = strict_yaml.listed(strict_yaml.text)(one)
    try:
        return tuple(str(ip_network(text)) for text in texts)
    except ValueError as error:
        raise WrongYaml(f'{one[0]} must be a list of networks such as 10.0.0.0/24 ({error})',
                        one[1]) from None


def _count(one: Field) -> int:
    count = strict_yaml.whole(one)
    if not 1 <= count <= 100:
        raise WrongYaml(f'{one[0]} is {count}, but must be 1 to 100', one[1])
    return count
