"""The displayed time to go, compared with the time that robots really need."""
from __future__ import annotations

import math
import random
from pathlib import Path
from typing import Optional, Sequence

import pytest
from proofs import is_whole

from fleet_core.fleet import RobotType
from fleet_core.supervision.fleet_view import robot_views
from fleet_core.supervision.missions import CommandKind, Request
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.driven_robot import AGV, LD90, Delays, DrivenRobot, RandomStops
from fleet_simulation.studied_fleet import RHYTHM
from fleet_simulation.virtual_fleet import VirtualFleet
from trajectory_graph import load_graph, split_edges

LAB = Path(__file__).parents[3] / 'maps' / 'lab_graph.yaml'
PLACES = (6, 18, 27, 39, 52)
DRIVES = 3      # missions that the robot serves before the displayed time must be right
MORE = 5 if is_whole(__file__) else 2
RIGHT = 0.2     # fraction of the true time by which the shown time may differ
TYPES = {
    'ld90': (RobotType('omron_ld90', 0.43, 1.35, play=0.25, obeys_edge_speed=False), LD90),
    'agv': (RobotType('agv', 0.4, 1.0), AGV)}


class Driving:
    """One robot that serves missions on the laboratory's graph, without people in its way."""

    def __init__(self, name: str, longest: float, parking: Optional[Sequence[int]] = None,
                 planning: float = 0.1) -> None:
        kind, mechanics = TYPES[name]
        graph = load_graph(LAB)
        self.graph = split_edges(graph, longest) if longest else graph
        delays = Delays(1.1, RandomStops(0.0, 0.0), RandomStops(0.0, 0.0))

        def make(robot: str, kind: RobotType, vertex: int) -> DrivenRobot:
            return DrivenRobot(robot, self.graph, kind, vertex, mechanics, delays,
                               random.Random(5), 1.0)
        self.fleet = VirtualFleet(self.graph, {'a': (kind, PLACES[0])}, make, check_every=100,
                                  planning=planning, settings=RobotSettings(release_ahead=8.0),
                                  parking=parking, rhythm=RHYTHM)
        self._random, self._count, self._at = random.Random(1), 0, PLACES[0]

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 10)):
            self.fleet.step()

    @property
    def shown(self):
        """The time to go to the next destination and to the end of the mission."""
        return robot_views(self.fleet.supervisor, self.fleet.now)[0].to_go

    def serve(self, stay: float):
        """Serves one mission. Returns the times shown when it began, and the true times."""
        places = self._random.sample([place for place in PLACES if place != self._at], 2)
        self._count, self._at = self._count + 1, places[-1]
        fleet, book = self.fleet, self.fleet.supervisor.book
        fleet.do(fleet.supervisor.request(
            Request(self._count, tuple(places), dwells=(stay, 0.0)), fleet.now))
        self.run(1.5)
        begun, shown, first = fleet.now, self.shown, math.nan
        while book.find(self._count).state.is_open:
            robot = fleet.supervisor.robots['a']
            if math.isnan(first) and book.find(self._count).dwell_until is not None:
                first = fleet.now - begun
            self.run(0.1)
            assert fleet.now - begun < 600.0, robot.why
        return shown, first, fleet.now - begun


@pytest.mark.parametrize('name', TYPES)
@pytest.mark.parametrize('longest', [0.0, 1.5])
def test_the_time_to_go_is_right_after_three_drives(name, longest):
    driving = Driving(name, longest)
    served = [driving.serve(stay=5.0) for _ in range(DRIVES + MORE)]
    driving.fleet.end()
    wrong = [shown.end / true - 1.0 for shown, _, true in served[DRIVES:]]
    assert max(map(abs, wrong)) < RIGHT, wrong
    first = [(shown.destination, true) for shown, true, _ in served[DRIVES:]]
    part = sum(shown for shown, _ in first) / sum(true for _, true in first) - 1.0
    assert abs(part) < RIGHT, first


def test_the_time_to_go_is_unknown_while_the_robot_must_stand():
    driving = Driving('agv', 0.0)
    fleet = driving.fleet
    fleet.do(fleet.supervisor.request(Request(1, (18, 39), dwells=(-1.0, 0.0)), fleet.now))
    assert math.isnan(driving.shown.destination), 'there is no plan yet'
    driving.run(2.0)
    assert driving.shown.destination > 5.0
    assert math.isnan(driving.shown.end), 'its stay ends when a person releases it'
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    assert math.isnan(driving.shown.destination)
    fleet.end()


def test_the_time_to_go_is_unknown_while_the_plan_is_that_of_the_last_mission():
    driving = Driving('agv', 0.0, parking=PLACES[:1], planning=1.0)
    fleet = driving.fleet
    executor, book = fleet.supervisor.plan_executor, fleet.supervisor.book
    fleet.do(fleet.supervisor.request(Request(1, (18,), dwells=(-1.0,)), fleet.now))
    while not book.find(1).dwell_until:
        driving.run(0.1)
    driving.run(1.0)
    assert executor.plan.plan_of('a').drives, 'after its stay it is to drive to a parking vertex'
    fleet.do(fleet.supervisor.request(Request(2, (PLACES[0], 39)), fleet.now))
    fleet.do(fleet.supervisor.command(1, CommandKind.RELEASE, fleet.now))
    shown = []
    while not (shown and not math.isnan(shown[-1])):
        driving.run(0.1)
        if book.of_robot('a') is book.find(2):
            shown.append(driving.shown.destination)
    fleet.end()
    assert math.isnan(shown[0]), 'that plan has the stay of mission 1, which has ended'
    assert shown[-1] < 100.0
