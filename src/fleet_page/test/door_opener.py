"""Opens a door in a fresh process, as the node does: `door_opener.py DESCRIPTORS SETTINGS`.

Prints the port. The door ends when the standard input ends.

DESCRIPTORS -- the largest number of descriptors that the door may use
SETTINGS -- the settings of the door, as JSON
"""
from __future__ import annotations

import json
import os
import resource
import sys

from fleet_page.core.acts import ActOutcome
from fleet_page.door.process import DoorProcess, DoorSettings


def stop(person: str) -> ActOutcome:
    """Stops no robot. The outcome says which process was asked."""
    return ActOutcome(True, f'stopped in process {os.getpid()}, whose arguments are none of a node')


def main(descriptors: int, settings: DoorSettings) -> None:
    """Opens the door, and closes it when the standard input ends."""
    resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors))
    process = DoorProcess(stop)
    print(process.open(settings), flush=True)
    sys.stdin.read()
    process.close()
    process.wait()


if __name__ == '__main__':
    main(int(sys.argv[1]), DoorSettings(**json.loads(sys.argv[2])))
