"""The fleet of a studied site in virtual time: its robots, their batteries, and all actors."""
from __future__ import annotations

from datetime import datetime, timedelta
from random import Random
from typing import Callable, Optional

from fleet_core.fleet import RobotType
from fleet_simulation.driven_robot import AGV, LD90, DrivenRobot
from fleet_simulation.report_times import Rhythm
from fleet_simulation.site import OrderPolicy, StudiedSite
from fleet_simulation.virtual_actors import VirtualActors
from fleet_simulation.virtual_fleet import VirtualFleet

MONDAY = datetime(2024, 1, 1)  # a Monday; daylight saving time does not begin or end soon after
RHYTHM = Rhythm(driving=2.0, standing=2.0, supervisor=0.5, room=1.0)
_BATTERY = 100      # number of steps between two battery reports
_CHECK_EVERY = 100  # number of events of the supervisor between two checks of the allocations


MakeRobot = Callable[[str, RobotType, int, Random], DrivenRobot]
"""Makes a robot with a name and a type on a vertex; the last argument draws its random values."""


class StudiedFleet:
    """A fleet of a given size. Its owner calls `begin` before the first step, and watches `world`.

    random -- draws the robots' charges and delays
    make   -- makes the robots; None: LD-90s and AGVs as the site describes them
    """

    def __init__(self, site: StudiedSite, robots: int, seed: int, random: Random,
                 make: Optional[MakeRobot] = None) -> None:
        self._site = site
        fleet, made = site.robots(robots), make or self._make
        self._drivers = {name: robot.driver for name, robot in fleet.items()}
        self.world: VirtualFleet[DrivenRobot] = VirtualFleet(
            site.graph, {name: (robot.type, robot.vertex) for name, robot in fleet.items()},
            lambda name, kind, vertex: made(name, kind, vertex, random), site.fleet.clearance,
            seed, planning=site.latency, settings=site.settings_of(fleet), parking=site.parking,
            dock_approach=site.fleet.dock_approach, rhythm=RHYTHM,
            switches=site.order is OrderPolicy.SWITCHING, check_every=_CHECK_EVERY,
            work=site.work, wall=(MONDAY + timedelta(minutes=site.begin)).timestamp())
        self.world.planner.rounds = site.rounds
        self._actors = VirtualActors(self.world, site.work, site.times, seed)
        self._steps = 0

    def _make(self, name: str, kind: RobotType, vertex: int, random: Random) -> DrivenRobot:
        mechanics = AGV if kind.obeys_edge_speed or self._drivers[name] == 'agv' else LD90
        return DrivenRobot(name, self._site.graph, kind, vertex, mechanics, self._site.delays,
                           Random(f'{name} {random.random()}'), random.uniform(0.5, 1.0))

    def begin(self) -> None:
        """Reports the charge of all batteries."""
        for name, robot in self.world.agvs.items():
            self.world.do(self.world.supervisor.battery(name, robot.charge, self.world.now))

    def stepped(self) -> None:
        """Does what is due after one time step of the world: steps at stops, battery reports."""
        self._steps += 1
        self._actors.stepped()
        if self._steps % _BATTERY == 0:
            self.begin()
