"""A fleet at work in virtual time, with robots that are late and stall.

The robots reach their speed at once. So the figures show the cost of the plans and of the
supervisor, and not the cost of acceleration and braking.
"""
from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Dict, Sequence, Tuple

from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_core.supervision.missions import Request, Status
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.agv.speed_limits import DriveLimits
from fleet_simulation.demand import Demand
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays, DrivenRobot, Mechanics, RandomStops
from fleet_simulation.figures import Figures
from fleet_simulation.simulation import Run
from fleet_simulation.site import StudiedSite, site_of
from trajectory_graph import Graph, load_graph, split_edges

ROOT = Path(__file__).resolve().parents[3]
DOCK = 16
STATIONS = (6, 18, 27, 39, 52, DOCK)
PARKING = (8, 10, 14, 32, 33, 35, 41, 18, 27, 39, 52, 6, DOCK)  # the largest well-formed set
# An AGV drives at the speed of the edge, at most 1 m/s here. The robots start at the first vertices
# of PARKING.
AGV = RobotType('agv', 0.43, 1.0, docks=frozenset((DOCK,)))
LD90 = RobotType('ld90', 0.43, 1.35, 0.25, False, docks=frozenset((DOCK,)))
STALLS = RandomStops(800.0, 20.0)
DELAYS = Delays(1.1, STALLS, RandomStops(0.0, 0.0))
AT_ONCE = Mechanics(DriveLimits(acceleration=100.0, braking=100.0, turn_rate=100.0,
                                turn_acceleration=1000.0, bend_rate=1e6))


class Operation(Run):
    """A run in which each robot gets a new goal when it has reached its previous goal.

    waiting -- number of further missions that are requested at the start, for any robot
    """

    def __init__(self, site: StudiedSite, robots: int, goals: Sequence[int], seed: int,
                 waiting: int = 0) -> None:
        def at_once(name: str, kind: RobotType, vertex: int, random: Random) -> DrivenRobot:
            return DrivenRobot(name, site.graph, kind, vertex, AT_ONCE, site.delays,
                               Random(f'{name} {random.random()}'), 1.0)
        super().__init__(site, robots, seed, at_once)
        self.longest_standstill = 0.0
        """The longest time in which no robot was driving, in s."""
        self._goals = goals
        self._draw = Random(seed)
        self._waiting = waiting
        self._next_id = 0
        self._missions: Dict[int, str] = {}
        """The robot of each open mission."""
        self._moved = 0.0
        """The virtual time at which a robot drove last."""

    def _request(self) -> None:
        while self._next_id < self._waiting:
            self._next_id += 1
            self._ask(Request(self._next_id, (self._draw.choice(self._goals),),
                              stamp=self.world.now + 0.1))
        for name in sorted(self.world.agvs.keys() - set(self._missions.values())):
            here = self.world.agvs[name].vehicle.drive.vertex
            goal = self._draw.choice([goal for goal in self._goals if goal != here])
            self._next_id += 1
            self._missions[self._next_id] = name
            self._ask(Request(self._next_id, (goal,), robot=name, stamp=self.world.now + 0.1))

    def publishes(self, status: Status) -> None:
        """Notes that a robot needs a new mission because its mission has ended."""
        super().publishes(status)
        if not status.state.is_open:
            self._missions.pop(status.request_id, None)

    def stepped(self) -> None:
        """Notes for how long no robot has driven."""
        super().stepped()
        now = self.world.now
        if any(not robot.vehicle.drive.at_rest for robot in self.world.agvs.values()):
            self._moved = now
        self.longest_standstill = max(self.longest_standstill, now - self._moved)


def at_work(graph: Graph, kind: RobotType, starts: Sequence[int], goals: Sequence[int],
            seed: int, seconds: float, rounds: int, waiting: int = 0,
            ) -> Tuple[Figures, Operation]:
    """Runs a fleet for this number of virtual seconds; each mission has one goal."""
    robots = tuple(Robot(f'r{k}', kind, start, '') for k, start in enumerate(starts))
    site = site_of(graph, Fleet((kind,), robots, 0.1),
                   {robot.name: RobotSettings(release_ahead=0.0) for robot in robots},
                   Wanted(Demand(()), DELAYS, {}, {}), rounds=rounds)
    run = Operation(site, len(robots), goals, seed, waiting)
    figures = run.run(seconds / 3600.0)
    if figures.trouble:
        raise RuntimeError(f'seed {seed}: {figures.trouble}')
    return figures, run


def in_the_laboratory(robots: int, longest: float, kind: RobotType, seed: int,
                      rounds: int = 100) -> Tuple[Figures, Operation]:
    """Returns the result of an hour on the example laboratory's graph. Its edges are cut into
    sections of at most `longest` m.
    """
    graph = split_edges(load_graph(ROOT / 'maps/lab_graph.yaml'), longest)
    return at_work(graph, kind, PARKING[:robots], STATIONS, seed, 3600.0, rounds)
