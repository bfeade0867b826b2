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
    """All that a restarted bridge needs: the state of `Vehicle`, and where the robot was sent."""

    vehicle: VehicleState
    target: Optional[int] = None  # index of the edge to whose end the robot was sent
    number: int = 0          # number of the command that sent it there; 0: not given yet
    owes_stop: bool = False  # the controller has not taken the stop that ended the route
    epoch: int = 0           # the controller's last epoch that the bridge knew
    foreign_epoch: int = 0   # the newest known epoch that the bridge did not begin
    last: Optional[RouteOrder] = None  # the last order that was taken; see `OldMasters`


# --- the robot ------------------------------------------------------------------------------------

@dataclass(frozen=True)
class RobotSeen:
    """One status of the robot. `activity` and `docking` belong to the same moment as `place`."""

    stamp: int
    activity: ActivityKind = ActivityKind.UNKNOWN
    docking: Optional[DockingState] = None
    place: Optional[Tuple[float, float]] = None  # m, map frame
    heading: Optional[float] = None  # rad, at that place


# --- our commands ---------------------------------------------------------------------------------

@dataclass(frozen=True)
class CommandEnded:
    """A command that `Give` requested has ended. `text` quotes the robot or the controller."""

    number: int
    ending: Outcome
    text: str = ''


# --- other givers, and the links ------------------------------------------------------------------

@dataclass(frozen=True)
class MotionTold:
    """The controller reports the epoch and the motion of the robot (omron_ld90_msgs/Motion).

    foreign_epoch -- the newest epoch that was begun not by the bridge, but by another giver,
        another client, the robot itself or its emergency stop; 0: it is the present epoch
    is_ours -- the robot obeys the bridge, or is in its emergency stop
    obeys_us -- the epoch began because the robot obeys a drive of the bridge
    reason -- why the epoch began, for a person
    cause -- why the epoch began, for programs
    is_unexplained -- the robot broke off a drive; the next epoch has the cause
    giver -- the node that drove or stopped the robot last; empty: no node, or it is unknown
    previous_epoch -- the epoch before this one; 0: none is known
    emergency_stop -- the emergency stop is pressed, or the motors are off after it
    number -- the number of the last command of the bridge that the controller has; 0: unknown
    fate -- the fate of this command; None: unknown

    The attributes are fields of the message `Motion`.
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
    giver: str = ''
    previous_epoch: int = 0


class RobotLink(Enum):
    """The two connections to the robot, with their names in omron_ld90_msgs/LinkState."""

    COMMANDS = 'commands'
    OUTGOING = 'outgoing'


@dataclass(frozen=True)
class LinkReported:
    """A report about a link, which the node that owns the link sends at least once a second."""

    link: RobotLink
    up: bool
    reason: str = ''


Event = Union[RouteOrder, RobotSeen, CommandEnded, MotionTold, LinkReported]


# --- actions --------------------------------------------------------------------------------------

@dataclass(frozen=True)
class Give:
    """The request to give the robot this ARCL command.

    A `CommandEnded` with this number must report the end of the command.

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
