"""A supervised fleet of simulated AGVs: missions are served whatever runs late."""
from __future__ import annotations

import pytest
from fleet_builders import AGV, corridor
from supervised_fleet import SupervisedFleet

from graph_fleet_manager.supervision.missions import MissionState
from graph_fleet_manager.supervision.reports import Report


def test_one_robot_serves_a_mission_in_order():
    fleet = SupervisedFleet(corridor(5), {'a': (AGV, 1)})
    fleet.request(1, 3, 2, 5)
    fleet.run_until_done(1)
    assert fleet.told(1) == [MissionState.PENDING, MissionState.ACTIVE, MissionState.SUCCEEDED]
    assert fleet.supervisor.robots['a'].place.vertex == 5
    assert fleet.agvs['a'].travelled == pytest.approx(2.0 * (2 + 1 + 3))


def test_two_robots_swap_their_places_through_a_siding_ten_times():
    fleet = SupervisedFleet(corridor(6, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 6)})
    for turn in range(10):
        ends = (6, 1) if turn % 2 == 0 else (1, 6)
        fleet.request(2 * turn + 1, ends[0], robot='a')
        fleet.request(2 * turn + 2, ends[1], robot='b')
        fleet.run_until_done(2 * turn + 1, 2 * turn + 2)
    assert fleet.nearest >= 0.0


def test_a_robot_that_does_not_know_yet_where_it_is_is_not_off_the_graph():
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    fleet.do(fleet.supervisor.report('a', Report(0), 0.0))
    fleet.request(1, 3)
    fleet.run_until_done(1)
    assert fleet.told(1)[-1] is MissionState.SUCCEEDED
