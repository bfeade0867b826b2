"""All AGVs of a simulation and their clock."""
from __future__ import annotations

import math
from typing import Callable, Dict, Iterable

from fleet_core.fleet import Robot
from fleet_simulation.agv.faults import UnknownAgvFault, inject
from fleet_simulation.agv.speed_limits import DriveLimits
from fleet_simulation.agv.vehicle import AgvVehicle
from trajectory_graph import Graph

LONGEST_STEP = 1.0  # s; longest wall time that one step simulates, even if more has passed


class Simulation:
    """AGVs on one graph. They do not detect each other; the fleet manager must keep them apart."""

    def __init__(self, graph: Graph, robots: Iterable[Robot], draw: Callable[[], int],
                 clock: Callable[[], int], speed: float = 1.0) -> None:
        """Creates the AGVs. The docstring of AgvVehicle describes `draw` and `clock`.

        speed -- simulated s per s of wall time
        """
        self.time = 0.0
        self.speed = speed
        self.vehicles: Dict[str, AgvVehicle] = {
            robot.name: AgvVehicle(robot.name, graph, robot.vertex, draw, clock,
                                   DriveLimits(speed=robot.type.speed), robot.type.obeys_edge_speed,
                                   robot.type.docks or ())
            for robot in robots}

    def advance(self, wall_seconds: float, stamp: int) -> None:
        """Simulates the next `wall_seconds`; the poses at the end get the stamp `stamp`."""
        seconds = min(wall_seconds, LONGEST_STEP) * self.speed
        self.time += seconds
        for vehicle in self.vehicles.values():
            vehicle.advance(seconds, stamp)

    def use_graph(self, graph: Graph) -> None:
        """Lets all AGVs use another graph from now on."""
        for vehicle in self.vehicles.values():
            vehicle.use_graph(graph)

    def where(self) -> Dict[str, object]:
        """Returns the simulated time (s), and the true pose of each AGV by its name (m, m,
        degrees).
        """
        robots = {}
        for name, vehicle in self.vehicles.items():
            x, y, heading = vehicle.pose
            robots[name] = {'x': x, 'y': y, 'heading': math.degrees(heading)}
        return {'time': self.time, 'robots': robots}

    def inject(self, line: str) -> None:
        """Injects a fault: `@NAME fault`, or `fault` for the first AGV. Raises UnknownAgvFault."""
        name, _, fault = line[1:].partition(' ') if line.startswith('@') else ('', '', line)
        vehicle = self.vehicles.get(name) if name else next(iter(self.vehicles.values()), None)
        if vehicle is None:
            raise UnknownAgvFault(f"there is no AGV '{name[:40]}'; there are: "
                                  f"{', '.join(self.vehicles)}")
        inject(vehicle, fault)
