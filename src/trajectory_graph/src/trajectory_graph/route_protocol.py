"""The values that a robot and the fleet manager speak of: orders in, reports and refusals out.

The rules are those of docs/interface/route_protocol.md. Stamps in nanoseconds of the ROS clock.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Tuple


@dataclass(frozen=True)
class RouteOrder:
    """Drive `edges` (signed ids) in this order, or stop where there are none."""

    route_id: int
    edges: Tuple[int, ...]
    stamp: int = 0  # when it was sent; 0 where the sender did not say
    received: int = field(default=0, compare=False)  # when it came


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


@dataclass(frozen=True)
class RouteReport:
    """What the fleet manager is told; `stamp` is that of the place reported."""

    stamp: int
    route_id: int
    edges: Tuple[int, ...]
    states: Tuple[EdgeState, ...]
    pose: SymbolicPose
    reason: str = ''


@dataclass(frozen=True)
class RouteRefusal:
    """An order that was not taken up."""

    route_id: int
    edges: Tuple[int, ...]
    reason: str


class Phase(Enum):
    """What became of a route."""

    RUNNING = 'running'
    COMPLETE = 'complete'
    FAILED = 'failed'
    STOPPED = 'stopped'
