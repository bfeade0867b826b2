"""The names of missions on a command line: the id of the request, or a short name that people say.

The short name has the serial of the mission: M42 is the 42nd mission that this site has accepted.
"""
from __future__ import annotations

import argparse
import re
from typing import NamedTuple

from fleet_core.supervision.missions import MissionState, short_name
from graph_fleet_manager.commands.command_line import NOT_DONE, CommandProblem, whole
from graph_fleet_manager.commands.fleet_client import TopicListener, first_message
from itrci_nav_msgs.msg import MissionStatus

_SHORT = re.compile(r'[Mm]([1-9]\d{0,9})')
_ID = re.compile(r'-?\d{1,10}')


class MissionName(NamedTuple):
    """A person's name for a mission; `number`: the mission's serial, or the id of its request."""

    number: int
    is_serial: bool = False

    def __str__(self) -> str:
        return short_name(self.number) if self.is_serial else str(self.number)

    def is_of(self, status: MissionStatus) -> bool:
        """Returns whether this is the name of the mission with this status."""
        return bool(self.number == (status.serial if self.is_serial else status.request_id))


def mission_name(text: str) -> MissionName:
    """Reads a name; raises ArgumentTypeError."""
    short = _SHORT.fullmatch(text)
    if short:
        return MissionName(int(short.group(1)), is_serial=True)
    if _ID.fullmatch(text):
        return MissionName(whole(text))
    raise argparse.ArgumentTypeError(f"{text!r} is neither the id of a mission nor a short name "
                                     'such as M42')


def open_mission(name: MissionName, listener: TopicListener) -> MissionStatus:
    """Returns the newest status of an open mission. Raises CommandProblem if there is none.

    listener -- on /mission_status: the fleet manager sends all open missions to a new subscriber
    """
    known = first_message(
        listener, lambda s: name.is_of(s) and MissionState(s.state).is_open, 2.0)
    if known is None:
        raise CommandProblem(f'There is no open mission {name}; see mission list.', NOT_DONE)
    return known


def request_id(name: MissionName) -> int:
    """Returns the id of a mission's request. A short name is found only for an open mission."""
    if not name.is_serial:
        return name.number
    return int(open_mission(name, TopicListener('/mission_status', MissionStatus)).request_id)
