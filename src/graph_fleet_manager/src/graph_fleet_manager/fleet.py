"""The robots of a fleet: what their types measure, how fast they are, how near they may come."""
from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet, Optional, Tuple

DOCK_APPROACH = 2.0  # m of free manoeuvre in front of a dock


@dataclass(frozen=True)
class RobotType:
    """What robots of one kind have in common; lengths in m, speeds in m/s.

    radius           -- of the disc that holds the robot however it turns
    speed            -- what it drives where the edge allows
    play             -- how far it may stray from its curve
    obeys_edge_speed -- does it keep to an edge's speed where that is lower? Where an edge's speed
                        is 0 no robot may drive, in any case
    docks            -- dock vertices at which it charges and may park; None: at none, but it may be
                        sent to any
    """

    name: str
    radius: float
    speed: float
    play: float = 0.0
    obeys_edge_speed: bool = True
    docks: Optional[FrozenSet[int]] = None

    def __hash__(self) -> int:
        """Of the name alone, for types are looked up often, and no two of a fleet share it."""
        return hash(self.name)

    @property
    def reach(self) -> float:
        """How far from its curve any part of the robot may be, in m."""
        return self.radius + self.play

    def drives_at(self, edge_speed: float) -> float:
        """Speed (m/s) on an edge with this speed; 0: it may not drive there."""
        if edge_speed <= 0.0:
            return 0.0
        return min(self.speed, edge_speed) if self.obeys_edge_speed else self.speed

    def may_dock(self, vertex: int) -> bool:
        """May it be sent to this dock?"""
        return self.docks is None or vertex in self.docks


@dataclass(frozen=True)
class Robot:
    """One robot and the vertex that it stands on at first.

    driver -- what drives it; `agv`: it is one that `agv_sim` simulates
    absent -- it is not on the site: in repair, or not delivered yet
    """

    name: str
    type: RobotType
    vertex: int
    driver: str = ''
    absent: bool = False


@dataclass(frozen=True)
class Fleet:
    """All robots that share a graph.

    clearance     -- m that stays free between any two robots
    dock_approach -- m before a dock in which no other robot drives while a robot docks or leaves
    """

    types: Tuple[RobotType, ...]
    robots: Tuple[Robot, ...]
    clearance: float = 0.0
    dock_approach: float = DOCK_APPROACH
