"""The robots of a fleet: the size and speed of their types, and the distance between robots."""
from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet, Optional, Tuple

DOCK_APPROACH = 2.0  # m in front of a dock in which a robot manoeuvres freely
# m: a robot farther from a vertex than this does not count as standing on it, even if it has play
NEAR = 0.3
# m from a vertex within which a robot without play counts as standing on it
AT_VERTEX = 0.02


@dataclass(frozen=True)
class RobotType:
    """The common properties of robots of one type. Lengths in m, speeds in m/s.

    radius           -- of the disc that contains the robot in each orientation
    speed            -- its speed if the edge allows it
    play             -- the distance by which it may stray from its curve
    obeys_edge_speed -- whether it slows down to the speed of an edge; an edge with speed 0 is
                        forbidden in any case
    docks            -- dock vertices at which it charges and may park; None: it charges and parks
                        at no dock, but may be sent to any dock
    without_load     -- name of the fleet's type from which this type was made for a load; empty:
                        this is a type of the fleet
    own_speed        -- the speed of the type `without_load`; 0: the same as `speed`
    closed           -- ids of the edges onto which it is not sent because of its load
    """

    name: str
    radius: float
    speed: float
    play: float = 0.0
    obeys_edge_speed: bool = True
    docks: Optional[FrozenSet[int]] = None
    without_load: str = ''
    own_speed: float = 0.0
    closed: FrozenSet[int] = frozenset()

    def __hash__(self) -> int:
        """The hash of the name alone: types are looked up often, and names are unique in a fleet.
        """
        return hash(self.name)

    @property
    def reach(self) -> float:
        """The largest distance of any part of the robot from its curve, in m."""
        return self.radius + self.play

    @property
    def nearness(self) -> float:
        """Distance (m) from a vertex within which the robot counts as standing on it."""
        return min(self.play + AT_VERTEX, NEAR)

    @property
    def model(self) -> str:
        """The name of the robot's type in the fleet file; a load does not change it."""
        return self.without_load or self.name

    @property
    def fastest(self) -> float:
        """The speed (m/s) that the robot never exceeds, even if it does not know of its load."""
        return max(self.speed, self.own_speed)

    @property
    def speed_limit(self) -> float:
        """The speed (m/s) that its load allows, as sent in orders; 0: the load sets no limit."""
        return self.speed if self.speed < self.own_speed else 0.0

    def drives_at(self, edge_speed: float) -> float:
        """Returns the robot's speed (m/s) on an edge with `edge_speed`; 0: it may not drive there.
        """
        if edge_speed <= 0.0:
            return 0.0
        return min(self.speed, edge_speed) if self.obeys_edge_speed else self.speed

    def may_dock(self, vertex: int) -> bool:
        """Returns whether a robot of this type may be sent to this dock."""
        return self.docks is None or vertex in self.docks


@dataclass(frozen=True)
class Robot:
    """One robot, and the vertex on which it stands at the beginning.

    driver -- the program that drives it; `agv`: `agv_sim` simulates it
    absent -- it is not at the site: in repair, or not delivered yet
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
    dock_approach -- m in front of a dock; no other robot enters them while a robot docks or leaves
    """

    types: Tuple[RobotType, ...]
    robots: Tuple[Robot, ...]
    clearance: float = 0.0
    dock_approach: float = DOCK_APPROACH

    @property
    def all_types(self) -> Tuple[RobotType, ...]:
        """The types that the fleet lists, and the types of its robots.

        A fleet that was not read from a file may list no types.
        """
        return (*self.types, *(robot.type for robot in self.robots))
