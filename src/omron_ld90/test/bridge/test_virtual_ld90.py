"""The LD-90 of the virtual fleet takes the same time for its routes as the simulated one."""
from __future__ import annotations

import statistics
from random import Random
from typing import Tuple

import pytest
from simulated_drive import SimulatedDrive

from fleet_core.fleet import RobotType
from fleet_simulation.driven_robot import LD90, Delays, DrivenRobot, RandomStops
from route_protocol.values import RouteOrder
from trajectory_graph import Graph
from trajectory_graph.shortest_paths import shortest_route

NEVER = RandomStops(0.0, 0.0)
KIND = RobotType('ld90', 0.43, 1.35, 0.25, obeys_edge_speed=False)
STEP = 0.1  # s
ROUTES = ((14, 40), (39, 8), (24, 41), (33, 42), (40, 4), (41, 1), (33, 18), (39, 14), (12, 49),
          (33, 39))


def test_it_takes_as_long_on_average_and_about_as_long_on_each_route() -> None:
    ratios = {}
    for start, goal in ROUTES:
        simulated = SimulatedDrive('rolling', vertex=start)
        route = shortest_route(simulated.graph, [start, goal])
        expected = simulated.drive(1, *route)
        ratios[start, goal] = seconds_of_virtual(simulated.graph, start, route) / expected
    assert statistics.mean(ratios.values()) == pytest.approx(1.0, abs=0.05), ratios
    assert max(abs(ratio - 1.0) for ratio in ratios.values()) < 0.2, ratios


def seconds_of_virtual(graph: Graph, start: int, route: Tuple[int, ...]) -> float:
    """Returns the seconds that the robot of the virtual fleet needs for the route."""
    robot = DrivenRobot('virtual', graph, KIND, start, LD90, Delays(1.0, NEVER, NEVER), Random(1),
                        1.0)
    robot.receive(RouteOrder(1, route))
    seconds = 0.0
    while robot.is_driving:
        robot.drive(STEP)
        seconds += STEP
    return seconds
