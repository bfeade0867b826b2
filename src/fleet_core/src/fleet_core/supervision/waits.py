"""What a mission or a robot waits for: a code for programs, words for people, and the time until
the wait ends.
"""
from __future__ import annotations

from enum import IntEnum
from math import nan
from typing import NamedTuple


class WaitCode(IntEnum):
    """The kind of a wait, as in itrci_nav_msgs/ExplainMission."""

    NOTHING = 0      # it drives, or may begin to drive
    ROBOT = 1        # a robot to serve the mission
    MISSIONS = 2     # other missions, which must end first
    START = 3        # the fleet manager has just started, or the fleet has just been resumed
    RESUME_FLEET = 4
    DISK = 5
    OUTAGE = 6       # its robot cannot work
    UNKNOWN = 7      # its robot has never reported
    RESUME = 8       # the mission is paused
    PERSON = 9       # an answer to a step, or a person who unloads the robot
    STEP = 10
    STAY = 11
    CHARGING = 12    # a charger, or a report of the battery
    PLAN = 13
    TRAFFIC = 14     # another robot, or an edge that may not be entered yet
    TIME = 15        # its earliest time
    RESOURCE = 16    # a door, a station or the like: its device, or the robot that claims it


class Wait(NamedTuple):
    """What a mission or a robot waits for.

    text  -- in words
    until -- s until the wait ends, at the latest or probably; NaN: unknown
    """

    code: WaitCode = WaitCode.NOTHING
    text: str = ''
    until: float = nan


NO_WAIT = Wait()
FLEET_STOPPED = Wait(WaitCode.RESUME_FLEET, 'the fleet is stopped')
STARTING = Wait(WaitCode.START, 'the reports of all robots: the fleet manager has just started')
