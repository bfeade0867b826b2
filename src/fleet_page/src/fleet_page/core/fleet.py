"""What the page knows of robots and missions: plain values, as the fleet manager told them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

ROBOT_STATES = ('IDLE', 'BUSY', 'CHARGING', 'OFFLINE', 'STOPPED', 'TAKEN_OVER', 'FAILED',
                'OFF_GRAPH', 'OUT_OF_SERVICE', 'ABSENT', 'UNKNOWN')
MISSION_STATES = ('PENDING', 'ACTIVE', 'SUCCEEDED', 'FAILED', 'REFUSED', 'CANCELLED', 'PAUSED')
OPEN_STATES = ('PENDING', 'ACTIVE', 'PAUSED')


@dataclass(frozen=True)
class Place:
    """A pose in the frame `map`: m, m, rad; `theta` None: not known."""

    x: float
    y: float
    theta: Optional[float]


@dataclass(frozen=True)
class Robot:
    """One robot.

    outage  -- as in itrci_nav_msgs/FleetRobot without OUTAGE_, NONE where it works
    edge    -- signed, 0 off the graph; fraction of it behind the robot
    seen    -- s since 1970, 0: never
    battery -- 0..1, None: unknown
    mission -- request id, None: it has none
    """

    name: str
    type: str
    state: str
    outage: str
    edge: int
    fraction: float
    seen: float
    battery: Optional[float]
    mission: Optional[int]
    destination: int
    waits_for: str


@dataclass(frozen=True)
class Plan:
    """What a robot drives next: signed edges, of which the first `released` may be driven.

    ends -- when each is driven, s since 1970
    """

    edges: Tuple[int, ...]
    released: int
    ends: Tuple[float, ...]


@dataclass(frozen=True)
class MissionStatus:
    """What was told of a mission; `stamp`, in ns, tells missions with one id apart.

    not_done -- the act that the reason says was not carried out; empty: the reason is the mission's
    """

    id: int
    stamp: int
    state: str
    robot: str
    reached: int
    reason: str
    not_done: str = ''


@dataclass(frozen=True)
class MissionRequest:
    """What a mission is to do."""

    id: int
    stamp: int
    destinations: Tuple[int, ...]
    robot: str
    robot_type: str
    priority: int
    requested_by: str = ''
