"""Robots that report only when it matters take as long as robots that report in each step."""
from __future__ import annotations

from random import Random
from typing import Dict, Tuple

import pytest
from fleet_builders import graph_of

from fleet_core.fleet import RobotType
from fleet_core.supervision.missions import Request
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.driven_robot import AGV, Delays, DrivenRobot, RandomStops
from fleet_simulation.report_times import Rhythm
from fleet_simulation.studied_fleet import RHYTHM
from fleet_simulation.virtual_fleet import STEP, VirtualFleet

NEVER = RandomStops(0.0, 0.0)
KIND = RobotType('agv', 0.4, 1.0)
LINE = graph_of({k: (4.0 * k, 0) for k in range(1, 8)}, {k: (k, k + 1) for k in range(1, 7)})
CROSS = graph_of({1: (0, 0), 2: (6, 0), 3: (12, 0), 4: (6, -6), 5: (6, 6)},
                 {1: (1, 2), 2: (2, 3), 3: (4, 2), 4: (2, 5)})
SITES = {'edges must be granted in time': (LINE, {'a': (1, 7)}),
         'one waits until another has left': (CROSS, {'a': (1, 3), 'b': (4, 5)})}


def run(name: str, rhythm: Rhythm) -> Tuple[float, int]:
    """Returns the seconds until all missions are done, and the number of reports."""
    graph, drives = SITES[name]
    random, reports = Random(1), []

    def make(robot: str, kind: RobotType, vertex: int) -> DrivenRobot:
        return DrivenRobot(robot, graph, kind, vertex, AGV, Delays(1.0, NEVER, NEVER), random, 1.0)
    starts: Dict[str, Tuple[RobotType, int]] = {
        robot: (KIND, start) for robot, (start, _) in drives.items()}
    fleet = VirtualFleet(graph, starts, make, settings=RobotSettings(release_ahead=1.5),
                         rhythm=rhythm)
    carry = fleet.network.carry_report
    fleet.network.carry_report = lambda *told: (reports.append(told), carry(*told))
    for number, (robot, (_, goal)) in enumerate(drives.items(), 1):
        fleet.do(fleet.supervisor.request(Request(number, (goal,), robot=robot), fleet.now))
    while fleet.supervisor.book.open:
        fleet.step()
        assert fleet.now < 200.0, fleet.picture()
    fleet.end()
    return fleet.now, len(reports)


@pytest.mark.parametrize('name', SITES)
def test_seldom_reports_make_no_robot_late(name: str) -> None:
    seconds, reports = run(name, RHYTHM)
    usual, all_reports = run(name, RHYTHM._replace(driving=STEP, standing=STEP))
    assert seconds == pytest.approx(usual, abs=0.5)
    assert reports < 0.4 * all_reports
