"""Who charges where: below one threshold a robot goes to a dock, above another it may leave it."""
from __future__ import annotations

import math
from typing import AbstractSet, Dict, List, Mapping

from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.supervision.assignment import time_to
from graph_fleet_manager.supervision.robots import ManagedRobot


class ChargeQueue:
    """Gives docks to robots that need them, the emptiest first; the others wait.

    granted -- the dock of each robot that charges or is on its way to do so
    """

    def __init__(self) -> None:
        self.granted: Dict[str, int] = {}
        self.waiting: List[str] = []

    def update(self, robots: Mapping[str, ManagedRobot], busy: AbstractSet[str],
               network: RoadNetwork) -> bool:
        """Looks at all batteries; tells whether anybody was given a dock or is charged.

        busy -- robots that serve a mission: they charge after it
        """
        before = dict(self.granted)
        for name in list(self.granted):
            robot = robots[name]
            if name in busy or not robot.works or (
                    robot.battery >= robot.settings.leave_above):
                del self.granted[name]
        needy = [robot for name, robot in robots.items()
                 if robot.works and name not in busy and name not in self.granted
                 and not math.isnan(robot.battery) and needs_charge(robot)]
        self.waiting = []
        for robot in sorted(needy, key=lambda r: r.battery):
            times = {dock: time_to(dock, robot, network)
                     for dock in docks_of(robot, network) if self._is_free(dock, robots)}
            times = {dock: time for dock, time in times.items() if time < math.inf}
            if times:
                self.granted[robot.name] = min(times, key=lambda dock: times[dock])
            else:
                self.waiting.append(robot.name)
        return self.granted != before

    def may_work(self, robot: ManagedRobot) -> bool:
        """Is a robot charged enough to be given a mission?"""
        return robot.name not in self.granted and not needs_charge(robot)

    def _is_free(self, dock: int, robots: Mapping[str, ManagedRobot]) -> bool:
        """Nobody has it, and nobody stands there who cannot leave."""
        return dock not in self.granted.values() and not any(
            not robot.works and robot.track.place is not None
            and robot.track.place.vertex == dock for robot in robots.values())


def needs_charge(robot: ManagedRobot) -> bool:
    """Is its battery below the threshold? One that does not tell counts as full."""
    return robot.battery < robot.settings.charge_below


def docks_of(robot: ManagedRobot, network: RoadNetwork) -> List[int]:
    """The docks at which a robot may charge."""
    return sorted(dock for dock in robot.type.docks or ()
                  if dock in network.index and network.graph.vertices[dock].dock)
