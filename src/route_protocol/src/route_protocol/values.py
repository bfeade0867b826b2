"""The values of the route protocol: a vehicle receives orders, and sends reports and refusals.

The docstrings of `vehicle` and `master` explain how these values work together.
docs/reference/route_protocol.md describes the messages. Stamps are in nanoseconds of the ROS clock.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Optional, Tuple

LARGEST_NUMBER = 2 ** 64 - 1
"""The largest number of an order, an epoch or a report that a message can carry."""
LARGEST_RECORD_NUMBER = 2 ** 32 - 1


@dataclass(frozen=True)
class RouteOrder:
    """An order to drive `edges` (signed ids) in the given sequence; without edges: an order to
    stop.

    route_id    -- a label of the route for people; if a master does not number its orders, the
                   label distinguishes its routes
    known_epoch -- the epoch in the vehicle's report on which the master based the order; 0: none
    order       -- number of the order, which grows; 0: the master does not number its orders
    first       -- number of `edges[0]` in the vehicle's route record
    master      -- the program that gave the order
    speed       -- m/s that the vehicle does not exceed because of its load; 0: no such limit
    stamp       -- time of sending; 0 if the sender did not give it
    received    -- time of reception
    """

    route_id: int
    edges: Tuple[int, ...]
    stamp: int = 0
    received: int = field(default=0, compare=False)
    known_epoch: int = field(default=0, compare=False)
    comes_again: bool = field(default=False, compare=False)
    """Whether the order was the first message of a new connection to a known latching publisher."""
    order: int = 0
    first: int = field(default=0, compare=False)
    master: str = ''
    speed: float = field(default=0.0, compare=False)

    @property
    def is_stop(self) -> bool:
        """Whether the order stops the vehicle."""
        return not self.edges

    @property
    def end(self) -> int:
        """The number in the route record that follows the last edge."""
        return self.first + len(self.edges)

    def is_repeat_of(self, other: RouteOrder) -> bool:
        """Returns whether both orders have the same route; their stamps may differ."""
        return (self.route_id, self.edges) == (other.route_id, other.edges)


ANSWERED_WITHIN = 4.0
"""A robot accepts or refuses an order within this time (s) after it first received the order."""


class EdgeState(IntEnum):
    """The state of one edge of a route. Accepted edges that are still ahead are PROCESSING."""

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

    Programs decide by the code. The text is a clause for people. As a condition, a reason with the
    code NONE is false.
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
class VehicleLocation:
    """The robot's pose in the map frame: m, m, rad; `theta` is NaN if it is unknown."""

    x: float
    y: float
    theta: float


class Motion(IntEnum):
    """What a vehicle does, according to its own reports."""

    UNKNOWN = 0
    """The vehicle does not know, for example because its link is down."""
    STANDING = 1
    """The vehicle stands, and has nothing to drive."""
    ON_ROUTE = 2
    """The vehicle drives a route of the master named in its report, or waits on this route."""
    COMING_TO_REST = 3
    """The vehicle lost a route of the master named in its report, and may still roll along it."""
    MOVED = 4
    """Another giver or a person moves the vehicle."""


class EpochCause(IntEnum):
    """Why the present epoch of a vehicle began. Numbers 1 to 7 are as in omron_ld90_msgs/Motion."""

    NONE = 0
    OTHER_GIVER = 1
    STOP = 2
    CANCEL = 3
    OTHER_CLIENT = 4
    ROBOT = 5
    EMERGENCY_STOP = 6
    RESTART = 7
    OTHER_MASTER = 8
    LOST_LINK = 9


@dataclass(frozen=True)
class RouteReport:
    """The report of a vehicle to its master.

    stamp    -- time of the reported position
    location -- the reported position in the map frame; None: unknown
    epoch    -- number of the vehicle's epoch, to be compared only for equality; 0: unknown
    cause    -- why that epoch began
    master   -- the master whose orders `order` and `refused` count; empty: no such master
    order    -- number of the last order that was taken in this epoch
    refused  -- highest number of an order that was refused in this epoch
    refusal  -- why that order was refused
    first    -- number of `edges[0]` in the route record
    motion   -- what the vehicle does
    number   -- number of this report; numbers only grow, even after a restart; 0: the vehicle does
                not number its reports
    unready  -- why the vehicle refuses every route now; NONE: there is no such reason

    Each attribute is a field of the message.
    """

    stamp: int
    route_id: int
    edges: Tuple[int, ...]
    states: Tuple[EdgeState, ...]
    pose: SymbolicPose
    reason: Reason = NO_REASON
    location: Optional[VehicleLocation] = None
    epoch: int = 0
    cause: EpochCause = EpochCause.NONE
    master: str = ''
    order: int = 0
    refused: int = 0
    refusal: Reason = NO_REASON
    first: int = 0
    motion: Motion = Motion.UNKNOWN
    number: int = 0
    unready: ReasonCode = ReasonCode.NONE

    @property
    def completed(self) -> int:
        """Number of edges before the first edge that is not COMPLETE."""
        for index, state in enumerate(self.states):
            if state is not EdgeState.COMPLETE:
                return index
        return len(self.states)

    @property
    def done(self) -> int:
        """Number in the route record of the first edge that is not COMPLETE."""
        return self.first + self.completed

    @property
    def is_failed(self) -> bool:
        """Whether the route of `order` has failed, or `order` was a stop."""
        return not self.edges or EdgeState.FAILED in self.states


@dataclass(frozen=True)
class RouteRefusal:
    """The refusal of an order, for people. The master reads the refusal in a report."""

    route_id: int
    edges: Tuple[int, ...]
    reason: Reason
    order: int = 0


class Phase(Enum):
    """The phase of a route."""

    RUNNING = 'running'
    COMPLETE = 'complete'
    FAILED = 'failed'
    STOPPED = 'stopped'
