"""Hindrances: why a robot does not get a mission that waits. The assignment uses them."""
from __future__ import annotations

from enum import IntEnum
from typing import Mapping


class Hindrance(IntEnum):
    """Why a robot cannot serve a mission, as in itrci_nav_msgs/RobotHindrance.

    If several hindrances apply, the first one in this list counts.
    """

    NONE = 0
    OTHER_ROBOT = 1
    OTHER_TYPE = 2
    DOCK = 3
    OUTAGE = 4
    HALTED = 5
    BUSY = 6
    LADEN = 7
    MUST_CHARGE = 8
    NO_PLACE = 9
    NO_WAY = 10
    BATTERY = 11
    FULL = 12

    @property
    def is_outage(self) -> bool:
        """Whether the robot can be given nothing at all to drive."""
        return self in (Hindrance.OUTAGE, Hindrance.HALTED)

    @property
    def is_free(self) -> bool:
        """Whether the robot is free for missions, although perhaps not for this one."""
        return self in (Hindrance.NONE, Hindrance.NO_WAY, Hindrance.BATTERY, Hindrance.FULL)


WORDS: Mapping[Hindrance, str] = {
    Hindrance.NONE: 'nothing: missions of a higher priority, or older ones, come first',
    Hindrance.OTHER_ROBOT: 'the mission is for another robot',
    Hindrance.OTHER_TYPE: 'the mission is for another type of robot',
    Hindrance.DOCK: 'it may not be sent to a dock of the mission',
    Hindrance.OUTAGE: 'it cannot work',
    Hindrance.HALTED: 'it was stopped, and has not gone on yet',
    Hindrance.BUSY: 'it serves mission {mission}',
    Hindrance.LADEN: 'it may carry the load of a mission that has ended',
    Hindrance.MUST_CHARGE: 'it must charge first',
    Hindrance.NO_PLACE: 'its place on the graph is unknown',
    Hindrance.NO_WAY: 'no open edges lead it to all destinations',
    Hindrance.BATTERY: 'its charge is too low for the whole mission',
    Hindrance.FULL: 'the station or charger of the first stop has no place for it now'}
