"""The command `peers`: lists the computers whose ROS masters are joined with ours.

    peers ADDRESS[,ADDRESS...] FLEET_FILE

Each of the two arguments may be empty. Prints a YAML list: the given addresses, and the `computer`
of each robot in the fleet file that has one. Exit status 0: done; 1: the list is empty or an
address is wrong; one sentence says so.
"""
from __future__ import annotations

import sys
from typing import List, Optional, Sequence

from fleet_core.files.errors import FileError
from fleet_core.files.robot_computers import is_address, load_computers
from graph_fleet_manager.commands.command_line import OK, WRONG


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    addresses, file = (given + ['', ''])[:2]
    try:
        print(f'[{", ".join(peers(addresses, file))}]')
    except (FileError, ValueError) as error:
        print(f'peers: {error}', file=sys.stderr)
        return WRONG
    return OK


def peers(addresses: str, fleet_file: str) -> List[str]:
    """Returns the addresses without repetition. Raises FileError, or ValueError with a sentence."""
    found = [address.strip() for address in addresses.split(',') if address.strip()]
    wrong = next((address for address in found if not is_address(address)), None)
    if wrong is not None:
        raise ValueError(f'{wrong!r} is neither an IPv4 address nor the name of a computer: set '
                         'peer:=ADDRESS to the address of the computer with the other ROS master.')
    if fleet_file:
        found += load_computers(fleet_file).values()
    if not found:
        where = f', and no robot in {fleet_file} has a computer:' if fleet_file else ''
        raise ValueError('There is no ROS master to join with: set peer:=ADDRESS to the address of '
                         f'the computer with the other ROS master{where}.')
    return list(dict.fromkeys(found))
