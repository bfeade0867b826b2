"""The values that routes are spoken of in: orders in, reports out, robot events, commands out.

Metres; `stamp` in nanoseconds of the ROS clock, exactly as it came with the robot's location.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Tuple, Union


@dataclass(frozen=True)
class RouteOrder:
    """The fleet manager's wish: drive `edges` (signed ids), or stop where there are none."""

    route_id: int
    edges: Tuple[int, ...]
    stamp: int = 0  # ns, when it was sent; 0 where the sender did not say


class EdgeState(IntEnum):
    """State of a route's edge; an accepted edge that is still ahead is PROCESSING too."""

    PROCESSING = 1
    COMPLETE = 2
    FAILED = 3


@dataclass(frozen=True)
class SymbolicPose:
    """Place on the graph: percentage (0..100) along the driving direction of a signed edge."""

    edge: int = 0  # 0 = off the graph
    percentage: float = 0.0


@dataclass(frozen=True)
class RouteReport:
    """What the fleet manager is told; `stamp` is that of the location used, 0 before any."""

    stamp: int
    route_id: int
    edges: Tuple[int, ...]
    states: Tuple[EdgeState, ...]
    pose: SymbolicPose
    reason: str = ''


@dataclass(frozen=True)
class RouteRecord:
    """What a restarted bridge must remember to go on with a route."""

    route_id: int
    edges: Tuple[int, ...]
    completed: int  # edges driven
    target: int     # index of the edge to whose end the robot was sent


# --- what the robot was seen or heard to do ------------------------------------------------------

@dataclass(frozen=True)
class Located:
    """The robot reported its place (m, map frame)."""

    stamp: int
    x: float
    y: float


@dataclass(frozen=True)
class GoalStarted:
    """`Going to <goal>`; an empty name is a goal without one (a point, a patrol, a task)."""

    goal: str


@dataclass(frozen=True)
class GoalReached:
    """`Arrived at <goal>`."""

    goal: str


@dataclass(frozen=True)
class GoalShown:
    """The status text says that the robot is going to `goal`; it may lag behind commands."""

    goal: str


@dataclass(frozen=True)
class MotionInterrupted:
    """`Interrupted: ...`: what ran was replaced or stopped."""

    text: str


@dataclass(frozen=True)
class RobotFailed:
    """The robot cannot go on; `text` is its words."""

    text: str


@dataclass(frozen=True)
class CommandRejected:
    """The robot did not take a command; `text` is its words."""

    command: str
    text: str


@dataclass(frozen=True)
class EmergencyStop:
    """The emergency stop is pressed, or was and the motors are still off; or no longer."""

    active: bool
    text: str = 'emergency stop'


class Docking(Enum):
    """Where the robot is between its path and its charging station."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


# --- what others did -------------------------------------------------------------------------

@dataclass(frozen=True)
class ForeignCommand:
    """A motion command that somebody else gave to the controller."""

    command: str
    caller: str


@dataclass(frozen=True)
class CommandRefused:
    """The controller did not pass on a command of ours."""

    command: str
    reason: str


@dataclass(frozen=True)
class LinkChanged:
    """A link to the robot came up or went down."""

    link: str
    up: bool
    reason: str = ''


RobotEvent = Union[Located, GoalStarted, GoalReached, GoalShown, MotionInterrupted, RobotFailed,
                   CommandRejected, EmergencyStop, Docking]
Event = Union[RobotEvent, RouteOrder, ForeignCommand, CommandRefused, LinkChanged]


# --- what is to be done ----------------------------------------------------------------------

@dataclass(frozen=True)
class Send:
    """Give the robot this ARCL command."""

    command: str


@dataclass(frozen=True)
class Note:
    """Tell the people who watch."""

    text: str


Action = Union[Send, RouteReport, Note]
