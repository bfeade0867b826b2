"""A robot of the simulated site: the drive of `agv_sim`, with docking, battery, and what delays it.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from random import Random
from typing import List, Optional, Tuple

from graph_fleet_manager.agv_simulator.speed_limits import DriveLimits
from graph_fleet_manager.agv_simulator.vehicle import Vehicle
from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking.reports import Pose, Report
from trajectory_graph import Graph
from trajectory_graph.route_protocol import RouteOrder, RouteRefusal

_EVER = 1e9  # s
_NANO = 1e9


@dataclass(frozen=True)
class Standstill:
    """About every `every` s of driving a robot stands still for `seconds`; 0: never."""

    every: float
    seconds: float


@dataclass(frozen=True)
class Delays:
    """How late robots run.

    slower -- each edge takes between 1 and so many times as long as it might
    stall  -- the robot itself does not go on
    people -- a person is in the way
    """

    slower: float = 1.1
    stall: Standstill = Standstill(3600.0, 20.0)
    people: Standstill = Standstill(900.0, 5.0)


@dataclass(frozen=True)
class Mechanics:
    """How a kind of robot drives.

    drive     -- its limits; the speed is that of its type in the fleet file
    docking, undocking -- s of manoeuvre on the edge to a dock, and on the one away
    """

    drive: DriveLimits
    docking: float = 0.0
    undocking: float = 0.0

    def limits(self, kind: RobotType) -> DriveLimits:
        """Of a robot of a type."""
        return replace(self.drive, speed=kind.speed)


LD90 = Mechanics(DriveLimits(acceleration=0.5, braking=0.2, turn_rate=1.75, turn_acceleration=3.14,
                             bend_rate=0.25, reverses=False), 12.0, 6.0)
"""From configurations of real robots. It brakes gently for bends and goals, and plans a path of its
own between goals: `bend_rate` is that at which its times are those of the simulated LD-90."""
AGV = Mechanics(DriveLimits())
"""As `agv_sim` drives."""


class DrivenRobot:
    """One robot with a drive, a battery and its own chance.

    charge -- at the beginning, 0..1
    """

    def __init__(self, name: str, graph: Graph, kind: RobotType, vertex: int,
                 mechanics: Mechanics, delays: Delays, random: Random, charge: float) -> None:
        self.graph, self.kind = graph, kind
        self.vehicle = Vehicle(name, graph, vertex, mechanics.limits(kind), kind.obeys_edge_speed,
                               kind.docks or (), 100.0 * charge)
        self.travelled = 0.0
        self._mechanics, self._delays, self._random = mechanics, delays, random
        self._refusals: List[RouteRefusal] = []
        self._edge: Tuple[Optional[int], int] = (None, -1)
        self._now = self._stands_until = 0.0

    @property
    def position(self) -> Tuple[float, float]:
        """x, y in m."""
        x, y, _ = self.vehicle.pose
        return x, y

    @property
    def is_driving(self) -> bool:
        """Has it anything to drive?"""
        return self.vehicle.running

    @property
    def is_held(self) -> bool:
        """Does it stand in the middle of its route, docking, stalled or before a person?"""
        return self.is_driving and self._now < self._stands_until

    @property
    def charge(self) -> float:
        """0..1."""
        return self.vehicle.battery.charge / 100.0

    def drive(self, seconds: float) -> None:
        """Lets time pass."""
        self._now += seconds
        vehicle = self.vehicle
        drive = vehicle.drive
        if vehicle.running:
            edge = drive.edge, drive.index
            if edge != self._edge and not drive.at_end:
                self._edge = edge
                self._begin(edge[0] or 0)
            for still in (self._delays.stall, self._delays.people):
                if still.every > 0.0 and not self.is_held and (
                        self._random.random() < seconds / still.every):
                    self._stand(still.seconds * self._random.uniform(0.5, 1.5))
            self.travelled += drive.speed * seconds
        vehicle.advance(seconds, int(self._now * _NANO))

    def _begin(self, edge: int) -> None:
        """Its pace on an edge, and the manoeuvre at a dock."""
        self.vehicle.slow_down(1.0 / self._random.uniform(1.0, self._delays.slower), _EVER)
        if self.graph.end_vertex(edge).dock:
            self._stand(self._mechanics.docking)
        elif self.graph.start_vertex(edge).dock:
            self._stand(self._mechanics.undocking)

    def _stand(self, seconds: float) -> None:
        if seconds > 0.0:
            self._stands_until = self._now + seconds
            self.vehicle.stall(seconds)

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Takes up a route; what it refuses it tells later."""
        self.vehicle.handle(RouteOrder(route_id, edges))
        return None

    def late_refusals(self) -> List[RouteRefusal]:
        """The orders that it refused since the last call."""
        return [message for message in self.vehicle.take_messages()
                if isinstance(message, RouteRefusal)]

    def report(self, stamp: float) -> Report:
        """What it tells."""
        told = self.vehicle.report()
        return Report(told.route_id, told.edges, told.states,
                      Pose(told.pose.edge, told.pose.percentage / 100.0), told.reason, stamp,
                      location=told.location)

    @property
    def news(self) -> object:
        """What of its report is told at once where it changes."""
        route = self.vehicle.route
        return route and (route.order.route_id, route.order.edges, route.completed, route.phase,
                          route.reason)

    def __str__(self) -> str:
        drive = self.vehicle.drive
        return f'{drive.path} {drive.index} at {drive.arc:.2f}, {self.vehicle.route}'
