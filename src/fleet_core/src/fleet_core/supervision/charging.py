"""Charging: which robots drive to docks, and until when they stay there.

    | a robot charges because         | until                                  | its missions |
    |---------------------------------|----------------------------------------|--------------|
    | its charge is below a threshold | another threshold                      | wait         |
    | a mission that waits needs more | that threshold                         | wait         |
    | it was asked to                 | the charge that was asked for          | wait         |
    | it has nothing to do, and is    | that threshold, but another robot that | begin        |
    | below a third threshold         | must charge gets its dock              |              |

The emptiest robot comes first. A dock that is given to a robot is given to no other one.
"""
from __future__ import annotations

import math
from typing import AbstractSet, Dict, List, Mapping

from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.assignment import time_to
from fleet_core.supervision.battery import MUTE
from fleet_core.supervision.robots import ManagedRobot

_MUTE = f'a report of its battery, which has not come for {MUTE:.0f} s'


class ChargeQueue:
    """Gives docks to the robots that need them, the emptiest first. The other robots wait.

    waiting -- for each robot that needs a dock and has none: what it waits for, in words
    """

    def __init__(self, robots: Mapping[str, ManagedRobot]) -> None:
        self.waiting: Dict[str, str] = {}
        self._robots = robots

    def update(self, busy: AbstractSet[str], short: AbstractSet[str],
               network: RoadNetwork, now: float) -> List[str]:
        """Checks all batteries. Returns the robots that got a dock or gave one back.

        busy  -- robots that serve a mission: they charge after it
        short -- robots whose charge is too low for a mission that waits for them
        """
        before = {name: (robot.dock, robot.charge_until) for name, robot in self._robots.items()}
        for robot in self._robots.values():
            if robot.charge_until and robot.battery.charge >= robot.charge_until:
                robot.charge_until = 0.0
            if robot.dock is not None and (
                    robot.name in busy or not _goes_on(robot, network, now)):
                _give_up(robot)
        self.waiting = {}
        free = [robot for name, robot in self._robots.items()
                if robot.works and name not in busy and robot.dock is None]
        for robot in sorted(free, key=_charge):
            self._check_battery(robot, robot.name in short, network, now)
        if not self.waiting:
            for robot in free:
                self._top_up(robot, network, now)
        return [name for name, robot in self._robots.items()
                if before[name] != (robot.dock, robot.charge_until)]

    def _top_up(self, robot: ManagedRobot, network: RoadNetwork, now: float) -> None:
        """Gives a robot that has nothing to do a dock that nobody else has."""
        if robot.dock is not None or not robot.battery.is_below_idle or (
                robot.battery.is_mute(robot.liveness, now)):
            return
        taken = {other.dock for other in self._robots.values()}
        times = {dock: time_to(dock, robot, network) for dock in docks_of(robot, network)
                 if dock not in taken and self._is_free(dock)}
        dock = min(times, key=lambda one: times[one], default=None)
        if dock is not None and times[dock] < math.inf:
            robot.dock, robot.tops_up = dock, True

    def _check_battery(self, robot: ManagedRobot, is_short: bool, network: RoadNetwork,
                       now: float) -> None:
        """Looks for a dock if the robot needs one; with a mute battery it waits for a report."""
        below = robot.battery.is_below_leaving
        wants = robot.battery.is_low or (is_short and below) or bool(robot.charge_until)
        if not robot.battery.is_mute(robot.liveness, now):
            if wants:
                self._look_for_dock(robot, network)
        elif wants or (below and robot.stands_at(docks_of(robot, network))):
            self.waiting[robot.name] = _MUTE

    def _look_for_dock(self, robot: ManagedRobot, network: RoadNetwork) -> None:
        docks = docks_of(robot, network)
        times = {dock: time_to(dock, robot, network) for dock in docks}
        free = [dock for dock in docks if times[dock] < math.inf and self._is_free(dock)]
        if free:
            dock = min(free, key=lambda dock: times[dock])
            for other in self._robots.values():
                if other.dock == dock:  # it only tops up
                    _give_up(other)
            robot.dock = dock
        elif not docks:
            self.waiting[robot.name] = 'a dock: the fleet file and the graph have none for its type'
        elif min(times.values()) == math.inf:
            self.waiting[robot.name] = 'a dock: it can reach none'
        else:
            self.waiting[robot.name] = 'a free dock'

    def _is_free(self, dock: int) -> bool:
        """No robot needs the dock, and no robot that cannot work stands on it."""
        return not any(robot.dock == dock and not robot.tops_up
                       or (not robot.works and robot.record.position is not None
                           and robot.record.position.vertex == dock)
                       for robot in self._robots.values())


def _give_up(robot: ManagedRobot) -> None:
    robot.dock, robot.tops_up = None, False


def _charge(robot: ManagedRobot) -> float:
    charge = robot.battery.charge
    return math.inf if math.isnan(charge) else charge


def _goes_on(robot: ManagedRobot, network: RoadNetwork, now: float) -> bool:
    """Does a robot keep its dock, because it still charges or can still get there?

    A robot that stands at its dock is not sent away by an outage. A robot that works, but whose
    battery does not report any more, might stay for ever. It must give the dock up.
    """
    if robot.dock not in docks_of(robot, network) or (
            robot.battery.may_leave and not robot.charge_until):
        return False
    if robot.works and robot.battery.is_mute(robot.liveness, now):
        return False
    if robot.dock is not None and robot.stands_at((robot.dock,)):
        return True
    return robot.works and time_to(robot.dock, robot, network) < math.inf


def docks_of(robot: ManagedRobot, network: RoadNetwork) -> List[int]:
    """The docks at which a robot may charge."""
    return sorted(dock for dock in robot.type.docks or ()
                  if dock in network.index and network.graph.vertices[dock].dock)
