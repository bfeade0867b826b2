"""The events and actions of the bridge, and the record that it keeps.

Lengths are in m; stamps in nanoseconds of the ROS clock. Orders and reports are those of
`route_protocol.values`.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Optional, Tuple, Union

from route_protocol.values import EpochCause, RouteOrder, RouteRefusal, RouteReport
from route_protocol.vehicle import VehicleState


@dataclass(frozen=True)
class RouteRecord:
    """All that a restarted bridge needs: what `Vehicle` knows, and where the robot was sent."""

    vehicle: VehicleState
    target: Optional[int] = None  # index of the edge to whose end the robot was sent
    number: int = 0          # of the command that sent it there; 0: it was not given yet
    owes_stop: bool = False  # the controller has not taken the stop that ended the route
    epoch: int = 0           # the controller's last epoch that the bridge knew
    last: Optional[RouteOrder] = None  # the last order that was taken; see `OldMasters`


# --- the robot ------------------------------------------------------------------------------------

class Motion(Enum):
    """The motion that the robot's status shows."""

    UNKNOWN = 'unknown'
    GOING = 'going to a goal'
    ARRIVED = 'arrived at a goal'
    FAILED = 'failed going to a goal'
    STOPPING = 'stopping'
    STANDING = 'standing'
    DOCKING = 'docking'
    DOCKED = 'docked'
    UNDOCKING = 'undocking'
    BY_HAND = 'driven by hand'


class Docking(Enum):
    """The state of the robot between its path and its charging station."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


@dataclass(frozen=True)
class RobotSeen:
    """One status of the robot. `goal` is empty if it names none, e.g. on the way to a point."""

    stamp: int
    motion: Motion = Motion.UNKNOWN
    goal: str = ''
    docking: Optional[Docking] = None
    emergency_stop: bool = False
    place: Optional[Tuple[float, float]] = None  # m, map frame
    heading: Optional[float] = None  # rad, at that place


# --- our commands ---------------------------------------------------------------------------------

class Ending(Enum):
    """How a command of the bridge ended."""

    SUCCEEDED = 'succeeded'
    FAILED = 'failed'
    INTERRUPTED = 'interrupted'              # another giver drives or stopped the robot
    CANCELLED = 'cancelled'                  # by another giver
    EMERGENCY_STOPPED = 'emergency stop'
    OVERRULED = 'overruled'                  # never sent: another giver's command came first
    LOST = 'lost'                            # it is unknown whether the robot obeys it
    NEVER_SENT = 'never sent'                # it did not reach the robot, for certain


class Fate(Enum):
    """What became of our last command, as the controller tells (omron_ld90_msgs/LastCommand)."""

    NONE = 0
    GIVEN = 1
    OBEYED = 2
    UNKNOWN = 3
    COMPLETED = 4
    FAILED = 5
    NOT_OBEYED = 6


@dataclass(frozen=True)
class CommandEnded:
    """A command given as `Give` has ended; `text` are the robot's words or the controller's."""

    number: int
    ending: Ending
    text: str = ''


# --- other givers, and the links ------------------------------------------------------------------

@dataclass(frozen=True)
class MotionTold:
    """The controller reports the epoch and the motion of the robot (omron_ld90_msgs/Motion).

    is_ours -- the bridge itself began the epoch, or an emergency stop
    obeys_us -- the robot has acknowledged a drive of the bridge
    by_robot -- the robot did something that no command of ours asked for
    goes_on -- the controller was restarted, and knows of no giver that did anything meanwhile
    reason -- why the epoch is a new one, for a person
    cause -- the same for programs
    drives -- the robot drives now
    number, fate -- the last command of the bridge that the controller has, and what became of it
    """

    epoch: int
    previous_epoch: int = 0
    is_ours: bool = False
    goes_on: bool = False
    stop_owed: bool = False
    reason: str = ''
    by_robot: bool = False
    cause: EpochCause = EpochCause.OTHER_GIVER
    drives: bool = False
    obeys_us: bool = False
    number: int = 0
    fate: Fate = Fate.NONE


class Link(Enum):
    """The two connections to the robot, by their names in omron_ld90_msgs/LinkState."""

    COMMANDS = 'commands'
    OUTGOING = 'outgoing'


@dataclass(frozen=True)
class LinkReported:
    """The report on a link by the node that owns it; sent at least once a second."""

    link: Link
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
class Note:
    """A message for a person."""

    text: str


Action = Union[Give, RouteReport, RouteRefusal, Note]
