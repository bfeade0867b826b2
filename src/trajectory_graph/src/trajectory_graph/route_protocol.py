"""The values of the route protocol: the robot receives orders, and sends reports and refusals.

docs/reference/route_protocol.md defines the rules. Stamps are in nanoseconds of the ROS clock.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Optional, Tuple


@dataclass(frozen=True)
class RouteOrder:
    """An order to drive `edges` (signed ids) in the given sequence; without edges: to stop."""

    route_id: int
    edges: Tuple[int, ...]
    stamp: int = 0  # time of sending; 0 if the sender did not give it
    received: int = field(default=0, compare=False)  # time of reception
    known_epoch: int = field(default=0, compare=False)  # epoch of the motion; 0: the stamp decides
    comes_again: bool = field(default=False, compare=False)
    """Whether it was the first message of a new connection to an earlier, latching publisher."""

    def is_repeat_of(self, other: RouteOrder) -> bool:
        """Returns whether it orders the same route again, regardless of its stamp."""
        return (self.route_id, self.edges) == (other.route_id, other.edges)


ANSWERED_WITHIN = 4.0
"""s after the first reception of an order within which a robot accepts or refuses it."""


class EdgeState(IntEnum):
    """The state of one edge of a route; an accepted edge that is still ahead is PROCESSING, too."""

    PROCESSING = 1
    COMPLETE = 2
    FAILED = 3


@dataclass(frozen=True)
class SymbolicPose:
    """A position on the graph: a signed edge, and a percentage (0..100) in driving direction."""

    edge: int = 0  # 0: off the graph
    percentage: float = 0.0


class ReasonCode(IntEnum):
    """The kind of a reason; itrci_nav_msgs/ReasonCode describes each code."""

    NONE = 0
    OTHER = 1
    TAKEN_OVER = 2
    EMERGENCY_STOP = 3
    LOST_LINK = 4
    NO_LOCATION = 5
    NO_PROGRESS = 6
    OFF_GRAPH = 7
    NOT_ARRIVED = 8
    DRIVE_FAILED = 9
    GRAPH_CHANGED = 10
    RESTARTED = 11
    BATTERY_EMPTY = 12
    STOP_OWED = 13
    WRONG_ROUTE = 14
    STARTS_ELSEWHERE = 15
    WRONG_CHANGE = 16
    CANNOT_BRAKE = 17
    CLOCK = 18
    NOT_READY = 19
    OVERRULED = 20


@dataclass(frozen=True)
class Reason:
    """The reason why a route failed, a stop is not obeyed, or an order was refused.

    Programs decide by the code. The text is a clause for people. A reason with the code NONE is
    false.
    """

    code: ReasonCode = ReasonCode.NONE
    text: str = ''

    def __bool__(self) -> bool:
        return self.code is not ReasonCode.NONE

    def __str__(self) -> str:
        return self.text


NO_REASON = Reason()
TAKEN_OVER = Reason(ReasonCode.TAKEN_OVER, 'taken over')
OVERRULED = Reason(ReasonCode.OVERRULED,
                   'the order was made before another giver drove or stopped the robot')
EMERGENCY_STOP = Reason(ReasonCode.EMERGENCY_STOP, 'emergency stop')


def reason_of(code: int, text: str) -> Reason:
    """Returns the reason of a message; an unknown code, or a text without a code, becomes OTHER."""
    try:
        known = ReasonCode(code)
    except ValueError:
        known = ReasonCode.OTHER
    return Reason(ReasonCode.OTHER if text and known is ReasonCode.NONE else known, text)


@dataclass(frozen=True)
class Location:
    """The robot's pose in the map frame: m, m, rad; `theta` is NaN if it is unknown."""

    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class RouteReport:
    """The robot's report to the fleet manager.

    stamp    -- time of the reported position
    location -- the reported position in the map frame; None: unknown
    epoch    -- epoch of the robot's motion; 0: unknown
    """

    stamp: int
    route_id: int
    edges: Tuple[int, ...]
    states: Tuple[EdgeState, ...]
    pose: SymbolicPose
    reason: Reason = NO_REASON
    location: Optional[Location] = None
    epoch: int = 0


@dataclass(frozen=True)
class RouteRefusal:
    """The refusal of an order."""

    route_id: int
    edges: Tuple[int, ...]
    reason: Reason


class Phase(Enum):
    """The phase of a route."""

    RUNNING = 'running'
    COMPLETE = 'complete'
    FAILED = 'failed'
    STOPPED = 'stopped'
