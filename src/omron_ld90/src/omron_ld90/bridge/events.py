"""The events and actions of the bridge, and the record that it keeps.

Lengths are in m; stamps in nanoseconds of the ROS clock. Orders and reports are those of
`route_protocol.values`.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Optional, Tuple, Union

from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import CommandFate, MotionState
from omron_arcl.replies import DockingState
from route_protocol.values import EpochCause, RouteOrder, RouteRefusal, RouteReport
from route_protocol.vehicle import VehicleState


@dataclass(frozen=True)
class BridgeMemory:
    """All that a restarted bridge needs: what `Vehicle` knows, and where the robot was sent."""

    vehicle: VehicleState
    target: Optional[int] = None  # index of the edge to whose end the robot was sent
    number: int = 0          # of the command that sent it there; 0: it was not given yet
    owes_stop: bool = False  # the controller has not taken the stop that ended the route
    epoch: int = 0           # the controller's last epoch that the bridge knew
    foreign_epoch: int = 0   # the newest one that the bridge did not begin, as it knew
    last: Optional[RouteOrder] = None  # the last order that was taken; see `OldMasters`


# --- the robot ------------------------------------------------------------------------------------

@dataclass(frozen=True)
class RobotSeen:
    """One status of the robot; `activity` and `docking` are those at its place and stamp."""

    stamp: int
    activity: ActivityKind = ActivityKind.UNKNOWN
    docking: Optional[DockingState] = None
    place: Optional[Tuple[float, float]] = None  # m, map frame
    heading: Optional[float] = None  # rad, at that place


# --- our commands ---------------------------------------------------------------------------------

@dataclass(frozen=True)
class CommandEnded:
    """A command given as `Give` has ended; `text` are the robot's words or the controller's."""

    number: int
    ending: Outcome
    text: str = ''


# --- other givers, and the links ------------------------------------------------------------------

@dataclass(frozen=True)
class MotionTold:
    """The controller reports the epoch and the motion of the robot (omron_ld90_msgs/Motion).

    foreign_epoch -- the newest epoch that the bridge did not begin: another giver, another client,
        the robot itself or its emergency stop did; 0: this one
    is_ours -- the robot obeys the bridge, or is in its emergency stop
    obeys_us -- the robot has acknowledged a drive of the bridge
    reason -- why the epoch is a new one, for a person
    cause -- the same for programs
    is_unexplained -- the robot broke off a drive, and the next epoch tells why
    emergency_stop -- the emergency stop is pressed, or the motors are off after it
    number, fate -- the last command of the bridge that the controller has, and what became of it;
        0, None: nothing was told yet

    Its attributes are fields of the message `Motion`.
    """

    epoch: int
    foreign_epoch: int = 0
    is_ours: bool = False
    stop_owed: bool = False
    reason: str = ''
    cause: EpochCause = EpochCause.OTHER_GIVER
    state: MotionState = MotionState.UNKNOWN
    emergency_stop: bool = False
    obeys_us: bool = False
    number: int = 0
    fate: Optional[CommandFate] = None
    is_unexplained: bool = False


class RobotLink(Enum):
    """The two connections to the robot, by their names in omron_ld90_msgs/LinkState."""

    COMMANDS = 'commands'
    OUTGOING = 'outgoing'


@dataclass(frozen=True)
class LinkReported:
    """The report on a link by the node that owns it; sent at least once a second."""

    link: RobotLink
    up: bool
    reason: str = ''


Event = Union[RouteOrder, RobotSeen, CommandEnded, MotionTold, LinkReported]


# --- actions --------------------------------------------------------------------------------------

@dataclass(frozen=True)
class Give:
    """Give the robot this ARCL command; a `CommandEnded` with this number must report its end.

    known_epoch -- the epoch in which the command is valid; 0: any
    """

    number: int
    command: str
    known_epoch: int = field(default=0, compare=False)


@dataclass(frozen=True)
class BridgeNote:
    """A message for a person."""

    text: str


Action = Union[Give, RouteReport, RouteRefusal, BridgeNote]
