"""What the bridge is told, what it does about it, and what it remembers.

Metres; stamps in nanoseconds of the ROS clock. Orders and reports are those of
`trajectory_graph.route_protocol`.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Optional, Tuple, Union

from trajectory_graph.route_protocol import (
    Phase,
    Reason,
    RouteOrder,
    RouteRefusal,
    RouteReport,
)


@dataclass(frozen=True)
class RouteRecord:
    """What a restarted bridge must remember of the last route, running or ended."""

    route_id: int
    edges: Tuple[int, ...]
    stamp: int
    phase: Phase
    reason: Reason
    completed: int           # edges driven
    target: Optional[int]    # index of the edge to whose end the robot was sent
    goal: str                # name of the goal that the robot was sent to last; empty: none
    owes_stop: bool = False  # the controller has not taken the stop that the end of it demanded
    epoch: int = 0           # of the motion, that the bridge knew
    past: Tuple[Tuple[int, int], ...] = ()  # orders that were driven: id, and a hash of the edges


# --- what the robot was seen to do ----------------------------------------------------------------

class Motion(Enum):
    """What the robot's status says that it does."""

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
    """Where the robot is between its path and its charging station."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


@dataclass(frozen=True)
class RobotSeen:
    """One status of the robot. `goal` is empty where it names none, e.g. on its way to a point."""

    stamp: int
    motion: Motion = Motion.UNKNOWN
    goal: str = ''
    docking: Optional[Docking] = None
    emergency_stop: bool = False
    place: Optional[Tuple[float, float]] = None  # m, map frame
    heading: float = math.nan  # rad, of that place


# --- what became of our commands ------------------------------------------------------------------

class Ending(Enum):
    """How a command that the bridge gave has ended."""

    SUCCEEDED = 'succeeded'
    FAILED = 'failed'
    INTERRUPTED = 'interrupted'              # another giver drives or stopped the robot
    CANCELLED = 'cancelled'                  # by another giver
    EMERGENCY_STOPPED = 'emergency stop'
    OVERRULED = 'overruled'                  # never sent: another giver's command came first
    LOST = 'lost'                            # it is unknown whether the robot obeys it
    NEVER_SENT = 'never sent'                # it certainly did not reach the robot


@dataclass(frozen=True)
class CommandEnded:
    """A command given as `Give` has ended; `text` is the robot's words or the controller's."""

    number: int
    ending: Ending
    text: str = ''


# --- what others did ------------------------------------------------------------------------------

@dataclass(frozen=True)
class MotionTold:
    """The controller tells the driver of the robot (omron_ld90_msgs/Motion).

    is_ours -- the bridge itself began the epoch, or an emergency stop did, which ends routes anyway
    by_robot -- the robot did something that no command of ours asked for
    goes_on -- the controller was restarted, and no giver did anything meanwhile as far as it knows
    reason -- why there is another epoch, for people
    """

    epoch: int
    previous_epoch: int = 0
    is_ours: bool = False
    goes_on: bool = False
    stop_owed: bool = False
    reason: str = ''
    by_robot: bool = False


class Link(Enum):
    """The two connections to the robot, by the names that omron_ld90_msgs/LinkState has."""

    COMMANDS = 'commands'
    OUTGOING = 'outgoing'


@dataclass(frozen=True)
class LinkReported:
    """The node that has this link says how it stands; it does so at least once a second."""

    link: Link
    up: bool
    reason: str = ''


Event = Union[RouteOrder, RobotSeen, CommandEnded, MotionTold, LinkReported]


# --- what is to be done ---------------------------------------------------------------------------

@dataclass(frozen=True)
class Give:
    """Give the robot this ARCL command, and tell by `CommandEnded` with this number how it ends.

    known_epoch -- of the motion, in which the command makes sense; 0: any
    """

    number: int
    command: str
    known_epoch: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Note:
    """Tell the people who watch."""

    text: str


Action = Union[Give, RouteReport, RouteRefusal, Note]
