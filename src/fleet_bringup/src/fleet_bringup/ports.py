"""TCP ports of this computer for simulated robots, connections of robots, and the page."""
from __future__ import annotations

import socket
from typing import Dict, Iterable, List, Sequence, Tuple

from fleet_bringup.errors import CannotStart
from fleet_bringup.options import Options
from fleet_bringup.robot_entries import AGV, LD90, RobotEntry


def needed_ports(entries: Sequence[RobotEntry], options: Options) -> List[Tuple[int, str]]:
    """Returns each port of this computer that is needed, and its purpose."""
    ports: List[Tuple[int, str]] = []
    for entry in entries:
        if entry.robot.driver == LD90:
            if entry.is_simulated:
                ports.append((entry.arcl_port, f'arcl_port of {entry.name}'))
            ports.append((entry.outgoing_port, f'outgoing_port of {entry.name}'))
    if any(entry.robot.driver == LD90 and entry.is_simulated for entry in entries):
        ports.append((options.control_port, 'control_port of the simulated LD-90s'))
    if any(entry.robot.driver == AGV for entry in entries):
        ports.append((options.control_port + 1, 'control_port of the simulated AGVs'))
    if options.fleet_manager and options.page:
        ports.append((options.page_port, 'page_port of the page for browsers'))
    return ports


def check_ports(ports: Iterable[Tuple[int, str]]) -> None:
    """Raises CannotStart for a port that is needed twice, or that another program uses."""
    users: Dict[int, str] = {}
    for port, what in ports:
        if port in users:
            raise CannotStart(f'TCP port {port} is {users[port]} and {what}: each needs its own.')
        users[port] = what
        if not 0 < port < 65536:
            raise CannotStart(f'{what} would be {port}, which is not a TCP port: begin with a '
                              'lower one.')
        if is_taken(port):
            name = what.partition(' ')[0]
            raise CannotStart(f'TCP port {port} ({what}) is in use: end the program that uses it, '
                              f'or choose another port with {name}:=PORT.')


def is_taken(port: int) -> bool:
    """Returns whether a program listens on the port, on any address of this computer."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(('', port))
        except OSError:
            return True
    return False
