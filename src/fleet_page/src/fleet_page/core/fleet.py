"""Robots and missions as plain values, as the fleet manager publishes them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

ROBOT_STATES = ('IDLE', 'BUSY', 'CHARGING', 'OFFLINE', 'STOPPED', 'TAKEN_OVER', 'FAILED',
                'OFF_GRAPH', 'OUT_OF_SERVICE', 'ABSENT', 'UNKNOWN')
MISSION_STATES = ('PENDING', 'ACTIVE', 'SUCCEEDED', 'FAILED', 'REFUSED', 'CANCELLED', 'PAUSED',
                  'CANCELLING', 'NEEDS_PERSON', 'BLOCKED')
OPEN_STATES = ('PENDING', 'ACTIVE', 'PAUSED', 'CANCELLING', 'NEEDS_PERSON', 'BLOCKED')


@dataclass(frozen=True)
class ShownPose:
    """A pose in the frame `map`: x (m), y (m), theta (rad); None: the heading is not known."""

    x: float
    y: float
    theta: Optional[float]


@dataclass(frozen=True)
class ShownRobot:
    """One robot.

    outage   -- name of the code in itrci_nav_msgs/FleetRobot without OUTAGE_; NONE if it works
    edge     -- signed id; 0: off the graph
    fraction -- part of the edge that is behind the robot, 0..1
    seen     -- time of its last report, s since 1970; 0: never
    battery  -- charge, 0..1; None: unknown
    mission  -- request id; None: it has no mission
    to_end   -- s until its mission ends, as the fleet manager expects; None: unknown
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
    to_end: Optional[float] = None


@dataclass(frozen=True)
class ShownPlan:
    """The next edges of a robot, with signed ids. The first `released` edges are released."""

    edges: Tuple[int, ...]
    released: int


@dataclass(frozen=True)
class MissionStatus:
    """The status of a mission. `stamp` (ns) distinguishes missions with the same id.

    not_done -- the act that was not carried out, for the given reason; empty: the reason concerns
                the mission itself
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
    """The request of a mission."""

    id: int
    stamp: int
    destinations: Tuple[int, ...]
    robot: str
    robot_type: str
    priority: int
    requested_by: str = ''
