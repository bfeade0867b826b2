"""The command `check_network`: checks whether the ROS masters of two computers can be joined.

    check_network HOST [--master-port N] [--discovery-port N]

Run it in the shell from which the nodes of this side are started. The other side must run.
It prints one line for each check, with advice. Exit status 0: no fault was found; 2: a check
failed; 1: wrong input.
"""
from __future__ import annotations

import os
import sys
from typing import List, Optional, Sequence

from fleet_core.files.robot_computers import is_address
from graph_fleet_manager.commands.command_line import NOT_DONE, OK, CommandProblem, Parser
from graph_fleet_manager.commands.fleet_client import run
from graph_fleet_manager.messages.definitions import own_definitions
from graph_fleet_manager.multimaster.findings import Grade
from graph_fleet_manager.multimaster.network_checks import NetworkChecks
from graph_fleet_manager.multimaster.peer_master import DISCOVERY_PORT, MASTER_PORT

_WORDS = {Grade.OK: 'ok', Grade.WARN: 'WARN', Grade.WRONG: 'WRONG'}


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    return run('check_network', _check, sys.argv[1:] if arguments is None else arguments)


def _check(arguments: List[str]) -> int:
    parser = Parser('check_network', description='Checks whether this computer and another one can '
                    'be joined by multimaster:=true, and says what to do if not.')
    parser.add_argument('host', help='address or name of the other computer')
    parser.add_argument('--master-port', type=int, default=MASTER_PORT,
                        help='port of the ROS master there (%(default)s)')
    parser.add_argument('--discovery-port', type=int, default=DISCOVERY_PORT,
                        help='port of master_discovery there (%(default)s)')
    options = parser.parse_args(arguments)
    if not is_address(options.host):
        raise CommandProblem(f'{options.host!r} is neither an IPv4 address nor the name of a '
                             'computer.')
    wrong = False
    for finding in NetworkChecks(options.host, os.environ, own_definitions(), options.master_port,
                                 options.discovery_port).run():
        print(f'{_WORDS[finding.level]:5}  {finding.subject}: {finding.text}', flush=True)
        if finding.advice:
            print(f'       -> {finding.advice}', flush=True)
        wrong = wrong or finding.level is Grade.WRONG
    return NOT_DONE if wrong else OK
