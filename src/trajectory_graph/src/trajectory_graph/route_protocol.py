"""The values that a robot and the fleet manager speak of: orders in, reports and refusals out.

The rules are those of docs/reference/route_protocol.md. Stamps in nanoseconds of the ROS clock.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Optional, Tuple


@dataclass(frozen=True)
class RouteOrder:
    """Drive `edges` (signed ids) in this order, or stop where there are none."""

    route_id: int
    edges: Tuple[int, ...]
    stamp: int = 0  # when it was sent; 0 where the sender did not say
    received: int = field(default=0, compare=False)  # when it came
    known_epoch: int = field(default=0, compare=False)  # of the motion; 0: the stamp decides
    comes_again: bool = field(default=False, compare=False)
    """Whether a connection began with it, to a publisher that latches and was there before."""

    def is_repeat_of(self, other: RouteOrder) -> bool:
        """Does it order the same route once more, whenever it was sent?"""
        return (self.route_id, self.edges) == (other.route_id, other.edges)


ANSWERED_WITHIN = 4.0
"""s after its first arrival within which a robot takes an order up, or refuses it."""


class EdgeState(IntEnum):
    """State of one place of a route; what is accepted and still ahead is PROCESSING, too."""

    PROCESSING = 1
    COMPLETE = 2
    FAILED = 3


@dataclass(frozen=True)
class SymbolicPose:
    """Place on the graph: percentage (0..100) along the driving direction of a signed edge."""

    edge: int = 0  # 0 = off the graph
    percentage: float = 0.0


class ReasonCode(IntEnum):
    """What kind of reason it is; as in itrci_nav_msgs/ReasonCode, which says more of each."""

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
    """Why a route failed, a stop is not obeyed, or an order was refused: programs decide by the
    code, the text, a clause, is for people. False where there is nothing to give a reason for."""

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
    """The reason of a message: a code that is not known here, or a text without a code, is OTHER.
    """
    try:
        known = ReasonCode(code)
    except ValueError:
        known = ReasonCode.OTHER
    return Reason(ReasonCode.OTHER if text and known is ReasonCode.NONE else known, text)


@dataclass(frozen=True)
class Location:
    """Where the robot is in the map frame: m, m, rad; `theta` is NaN where it is not known."""

    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class RouteReport:
    """What the fleet manager is told; `stamp` is that of the place reported.

    location -- that place in the map frame; None: it is not known
    epoch -- of the robot's motion; 0: none is known
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
    """An order that was not taken up."""

    route_id: int
    edges: Tuple[int, ...]
    reason: Reason


class Phase(Enum):
    """What became of a route."""

    RUNNING = 'running'
    COMPLETE = 'complete'
    FAILED = 'failed'
    STOPPED = 'stopped'
