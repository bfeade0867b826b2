"""A robot of a simulated site: an AGV of `agv_sim` with docking, a battery and random delays."""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from random import Random
from typing import List, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_simulation.agv.speed_limits import DriveLimits
from fleet_simulation.agv.vehicle import AgvVehicle
from route_protocol.values import RouteOrder, RouteRefusal, RouteReport
from trajectory_graph import Graph

_EVER = 1e9  # s
_TOGETHER = 1e-6  # s; events with a smaller time difference happen at the same time
_NANO = 1e9


@dataclass(frozen=True)
class RandomStops:
    """Random stops of a robot.

    every   -- mean s of driving between two stops; 0: the robot never stops
    seconds -- mean s of one stop; each is drawn between 0.5 and 1.5 times this
    """

    every: float
    seconds: float


@dataclass(frozen=True)
class Delays:
    """The delays that make robots late.

    slower -- the time for an edge is drawn between 1 and `slower` times its shortest driving time
    stall  -- stops that the robot itself causes
    people -- stops because a person is in the way
    """

    slower: float = 1.1
    stall: RandomStops = RandomStops(3600.0, 20.0)
    people: RandomStops = RandomStops(900.0, 5.0)


@dataclass(frozen=True)
class Mechanics:
    """How one kind of robot drives.

    drive     -- limits of the drive; the robot type in the fleet file gives the speed instead
    docking   -- duration (s) of the manoeuvre on the edge to a dock
    undocking -- duration (s) of the manoeuvre on the edge away from a dock
    """

    drive: DriveLimits
    docking: float = 0.0
    undocking: float = 0.0

    def limits(self, kind: RobotType) -> DriveLimits:
        """Returns the drive limits of a robot of the given type."""
        return replace(self.drive, speed=kind.speed)


LD90 = Mechanics(DriveLimits(acceleration=0.5, braking=0.2, turn_rate=1.75, turn_acceleration=3.14,
                             bend_rate=0.25, reverses=False), 12.0, 6.0)
"""An LD-90; the values come from configurations of real robots. The LD-90 brakes gently for bends
and goals, and plans its own path between goals. Therefore `bend_rate` is chosen such that the
driving times equal those of the simulated LD-90.
"""
AGV = Mechanics(DriveLimits())
"""An AGV that drives as `agv_sim` does."""


class DrivenRobot:
    """One robot with a drive, a battery and its own random number generator.

    An event is one of these: the robot passes a vertex, ends a turn, comes to rest, or begins or
    ends a random stop. Until the next event its motion is known in closed form, so the world need
    not drive it before `due`.

    vertex -- id of the vertex on which it begins
    charge -- charge of the battery at the beginning, 0..1
    """

    def __init__(self, name: str, graph: Graph, kind: RobotType, vertex: int,
                 mechanics: Mechanics, delays: Delays, random: Random, charge: float) -> None:
        self.graph, self.kind = graph, kind
        self._now = self._stands_until = 0.0
        self.due = self._event = 0.0
        """Virtual time (s) until which the robot's report does not change, except for its place."""
        epochs = Random(f'epochs of {name}')
        self.vehicle = AgvVehicle(name, graph, vertex, lambda: epochs.getrandbits(63) or 1,
                                  lambda: int(1000.0 * self._now), mechanics.limits(kind),
                                  kind.obeys_edge_speed, kind.docks or (), 100.0 * charge)
        self._mechanics, self._random = mechanics, random
        self._kinds = tuple(still for still in (delays.stall, delays.people) if still.every > 0.0)
        self._stops = [self._driving_until(still) for still in self._kinds]
        """For each kind of random stop: seconds of driving until the next stop."""
        self._slower = delays.slower
        self._edge: Tuple[Optional[int], int] = (None, -1)

    @property
    def travelled(self) -> float:
        """The distance (m) driven so far."""
        return self.vehicle.drive.driven

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y in m, in the frame of the graph."""
        x, y, _ = self.vehicle.pose
        return x, y

    @property
    def is_driving(self) -> bool:
        """Whether the robot has a route that is not finished."""
        return self.vehicle.running

    @property
    def is_held(self) -> bool:
        """Whether the robot stands on its route: it docks, is stalled, or a person blocks it."""
        return self.is_driving and self._now < self._stands_until

    @property
    def charge(self) -> float:
        """The charge of the battery, 0..1."""
        return self.vehicle.battery.charge / 100.0

    def drive(self, seconds: float) -> None:
        """Advances the robot by the given virtual time, in s."""
        end = self._now + seconds
        while self._now < end - _TOGETHER:
            is_known = self._event > self._now
            self._pass((min(end, self._event) if is_known else end) - self._now)
            if not is_known or self._now >= self._event - _TOGETHER:
                self._begin_edge()
                self._plan()

    @property
    def _drives(self) -> bool:
        """Whether the robot drives now, so that the time until its next random stop passes."""
        return self.vehicle.running and not self.is_held

    def _plan(self) -> None:
        """Computes the time of the robot's next event. If it is unknown, uses the present time."""
        known = self.vehicle.next_event
        if known > 0.0:
            known = max(min(known, *(self._stops if self._drives else ()), _EVER), _TOGETHER)
        self._event = self._now + known
        self.due = self._event - _TOGETHER

    def _pass(self, seconds: float) -> None:
        """Advances the robot by `seconds`; an event may happen only at their end."""
        drives = self._drives
        self._now += seconds
        self.vehicle.advance(seconds, int(self._now * _NANO))
        if not drives:
            return
        for number, still in enumerate(self._kinds):
            self._stops[number] -= seconds
            if self._stops[number] <= _TOGETHER:
                self._stops[number] = self._driving_until(still)
                if not self.is_held and self.vehicle.running:
                    self._stand(still.seconds * self._random.uniform(0.5, 1.5))

    def _driving_until(self, still: RandomStops) -> float:
        """Draws the seconds of driving until the next stop of this kind."""
        return self._random.expovariate(1.0 / still.every)

    def _begin_edge(self) -> None:
        drive = self.vehicle.drive
        edge = drive.edge, drive.index
        if self.vehicle.running and edge != self._edge and not drive.at_end:
            self._edge = edge
            self._begin(edge[0] or 0)

    def _begin(self, edge: int) -> None:
        """Draws the pace on a new edge; begins the manoeuvre on an edge to or from a dock."""
        self.vehicle.slow_down(1.0 / self._random.uniform(1.0, self._slower), _EVER)
        if self.graph.end_vertex(edge).dock:
            self._stand(self._mechanics.docking)
        elif self.graph.start_vertex(edge).dock:
            self._stand(self._mechanics.undocking)

    def _stand(self, seconds: float) -> None:
        if seconds > 0.0:
            self._stands_until = self._now + seconds
            self.vehicle.stall(seconds)

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        """Gives the robot an order. Returns None; `late_refusals` returns refusals."""
        self.vehicle.handle(order)
        self._begin_edge()
        self._plan()
        return None

    def late_refusals(self) -> List[RouteRefusal]:
        """Returns the refusals since the last call."""
        return [message for message in self.vehicle.new_messages()
                if isinstance(message, RouteRefusal)]

    def seconds_left(self, ahead: float) -> float:
        """Returns the seconds until only `ahead` m of its route are left.

        Infinite: no more than `ahead` m are left now, or the robot stops earlier.
        """
        distance = self.vehicle.left - ahead
        return self._seconds_until(distance) if distance > 0.0 else math.inf

    def seconds_past(self, number: int, fraction: float, distance: float) -> float:
        """Returns the seconds until the robot is `distance` m past the point at `fraction` of an
        edge.

        0: the robot is already there. Infinite: it stops earlier.

        number -- number of the edge in the robot's route record
        """
        return self._seconds_until(self.vehicle.distance_to(number, fraction) + distance)

    def _seconds_until(self, distance: float) -> float:
        if distance <= 0.0:
            return 0.0
        return self.vehicle.drive.seconds_until(distance) if self._drives else math.inf

    def told(self, stamp: int) -> RouteReport:
        """Returns the robot's next report, with this stamp (ns)."""
        return replace(self.vehicle.report(), stamp=stamp)

    def report(self, stamp: float) -> RouteReport:
        """Returns the robot's next report, with this stamp (s)."""
        return self.told(round(stamp * _NANO))

    @property
    def news(self) -> object:
        """The values whose changes are reported at once."""
        return self.vehicle.news

    def __str__(self) -> str:
        drive = self.vehicle.drive
        return f'{drive.path} {drive.index} at {drive.arc:.2f}, {self.vehicle.state}'
