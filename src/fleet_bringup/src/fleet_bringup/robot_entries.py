"""The keys of a fleet file that are needed only to start the robots.

    robots:
    - {name: ld90_1, type: ld90, vertex: 16, driver: ld90, host: 10.0.0.5, arcl_port: 7171,
       outgoing_port: 7179, password_file: secrets/ld90_1}
    - {name: ld90_2, type: ld90, vertex: 18, driver: ld90, start: [-9.2, 7.2, -90]}
    - {name: agv_1, type: agv, vertex: 8, driver: agv}
    - {name: visitor, type: agv, vertex: 10, driver: none}
    - {name: ld90_3, type: ld90, vertex: 6, driver: ld90, computer: 10.0.0.21}

- An LD-90 with a `host` is a real robot. Without a `host` it is simulated.
- All AGVs are simulated.
- For a robot with the driver `none` nothing is started, because it has its own software.
- A robot with a `computer` has its own ROS master there. This master is joined with the fleet's.
"""
from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Sequence, Tuple

import yaml

from fleet_bringup.errors import CannotStart
from fleet_bringup.options import Options
from fleet_core.files.errors import FileError
from fleet_core.files.robot_computers import computer
from fleet_core.fleet import Fleet, Robot
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

LD90, AGV, NONE = 'ld90', 'agv', 'none'
PORT_STEP = 10  # difference between the ports of two successive simulated robots

_NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]*\Z')


@dataclass(frozen=True)
class RobotEntry:
    """The data to start one robot.

    line     -- line of the robot in the fleet file
    host     -- address of a real robot; empty: it is simulated
    start    -- x (m), y (m) and heading (degrees) of a simulated robot; None: on its vertex
    computer -- address of the robot's own computer. Then nothing is started here, and its driver
                is `none`
    """

    robot: Robot
    line: int
    host: str = ''
    arcl_port: int = 0
    outgoing_port: int = 0
    password_file: str = ''
    start: Optional[Tuple[float, float, float]] = None
    computer: str = ''

    @property
    def name(self) -> str:
        """The name of the robot."""
        return self.robot.name

    @property
    def is_simulated(self) -> bool:
        """Whether this computer simulates the robot."""
        return not self.host and self.robot.driver != NONE


def read_entries(path: str, fleet: Fleet, options: Options) -> List[RobotEntry]:
    """Returns the entries of all robots of a fleet file that `load_fleet` has read.

    Raises FileError.
    """
    try:
        root = strict_yaml.compose(path)
        whole = strict_yaml.mapping(root, 'the file')
        entries = []
        simulated = 0
        for robot, node in zip(fleet.robots, strict_yaml.items(
                strict_yaml.field(whole, 'robots', root))):
            entry = _entry(robot, node, os.path.dirname(path), options, simulated)
            simulated += robot.driver == LD90 and entry.is_simulated
            entries.append(entry)
        _check_each_other(entries)
        return entries
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def _entry(robot: Robot, node: yaml.Node, folder: str, options: Options,
           simulated: int) -> RobotEntry:
    given = strict_yaml.mapping(node, f'robot {robot.name}')
    if not _NAME.match(robot.name):
        raise WrongYaml(f'robot {robot.name} needs a name of letters, digits and _ that begins with'
                        ' a letter: it becomes part of topics', given['name'])
    driver = strict_yaml.choice((LD90, AGV, NONE), 'a driver')(
        strict_yaml.field(given, 'driver', node))
    if 'computer' in given:
        if driver == AGV:
            raise WrongYaml(f'robot {robot.name}: driver agv is simulated here; with a computer of '
                            'its own its driver is ld90 or none', given['computer'])
        return RobotEntry(replace(robot, driver=NONE), strict_yaml.line_of(node),
                          computer=computer(('computer', given['computer'])))
    if driver != LD90:
        wrong = next((key for key in ('host', 'arcl_port', 'outgoing_port', 'password_file')
                      if key in given), None)
        if wrong:
            raise WrongYaml(f'robot {robot.name}: {wrong} is for driver ld90 only', given[wrong])
        return RobotEntry(robot, strict_yaml.line_of(node))
    host = strict_yaml.optional(given, 'host', strict_yaml.text, '')
    step = 0 if host else PORT_STEP * simulated
    password = strict_yaml.optional(given, 'password_file', strict_yaml.text, '')
    if host and not password:
        raise WrongYaml(f'robot {robot.name} has a host, but no password_file: name the file that '
                        'contains its ARCL password, and nothing else', node)
    if password:
        password = os.path.join(folder, os.path.expanduser(password))
        if not os.access(password, os.R_OK):
            raise WrongYaml(f'robot {robot.name}: password_file {password} cannot be read',
                            given['password_file'])
    return RobotEntry(
        robot, strict_yaml.line_of(node), host,
        strict_yaml.optional(given, 'arcl_port', tcp_port, options.arcl_port + step),
        strict_yaml.optional(given, 'outgoing_port', tcp_port, options.outgoing_port + step),
        password, strict_yaml.optional(given, 'start', _start, None))


def _check_each_other(entries: Sequence[RobotEntry]) -> None:
    """Raises WrongYaml if two robots have the same vertex, host or port."""
    users: Dict[str, RobotEntry] = {}
    for entry in entries:
        own = [f'vertex {entry.robot.vertex}']
        if entry.host:
            own.append(f'host {entry.host}')
        if entry.robot.driver == LD90:
            own += [f'ARCL port {entry.arcl_port} of {entry.host or "127.0.0.1"}',
                    f'outgoing_port {entry.outgoing_port}']
        for what in own:
            other = users.setdefault(what, entry)
            if other is not entry:
                raise WrongYaml(f'robots {other.name} (line {other.line}) and {entry.name} have '
                                f'the same {what}; each needs its own', entry.line)


def tcp_port(one: Field) -> int:
    """Returns the TCP port in a field; raises WrongYaml."""
    port = strict_yaml.whole(one)
    if not 0 < port < 65536:
        raise WrongYaml(f'{one[0]} is {port}, but must be a TCP port from 1 to 65535', one[1])
    return port


def _start(one: Field) -> Tuple[float, float, float]:
    numbers = strict_yaml.listed(strict_yaml.real)(one)
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise WrongYaml(f'{one[0]} must be a list of x (m), y (m) and heading (degrees)', one[1])
    return numbers[0], numbers[1], numbers[2]


def check_count(fleet: Fleet, capacity: int, source: str) -> None:
    """Raises CannotStart if the fleet has more robots than the graph can park."""
    if len(fleet.robots) > capacity:
        raise CannotStart(
            f'{source} has {len(fleet.robots)} robots, but the graph has places for {capacity} to '
            'park without cutting any robot off: take some out, or give the graph more dead ends.')
