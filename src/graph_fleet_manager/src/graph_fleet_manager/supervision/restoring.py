"""The robots of a fleet as they were before a restart, as far as fleet and graph still have it."""
from __future__ import annotations

from typing import Dict, Mapping

from graph_fleet_manager.fleet import Fleet
from graph_fleet_manager.supervision.journal import RobotMemory
from graph_fleet_manager.supervision.robots import ManagedRobot
from graph_fleet_manager.supervision.route_client import RouteClient
from graph_fleet_manager.supervision.route_record import RouteRecord
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import Graph


def robots_of(fleet: Fleet, settings: Mapping[str, RobotSettings], graph: Graph,
              memories: Mapping[str, RobotMemory]) -> Dict[str, ManagedRobot]:
    """Every robot by its name, with what is stored of it.

    settings -- those that are missing are as RobotSettings has them
    """
    robots: Dict[str, ManagedRobot] = {}
    for robot in fleet.robots:
        own = settings.get(robot.name, RobotSettings())
        managed = ManagedRobot(robot.name, robot.type, own,
                               RouteClient(RouteRecord(graph, robot.type.speed, own.slack)))
        if robot.name in memories:
            _restore(managed, memories[robot.name], graph)
        robots[robot.name] = managed
    return robots


def _restore(robot: ManagedRobot, memory: RobotMemory, graph: Graph) -> None:
    robot.client.restore(memory.client.on(graph))
    if memory.outage is not None and memory.outage.needs_person:
        robot.outage, robot.why = memory.outage, memory.why
    robot.is_halted, robot.comes_to_rest = memory.is_halted, memory.comes_to_rest
    robot.dock = memory.dock
    if memory.charge is not None:
        robot.battery.charge = memory.charge
