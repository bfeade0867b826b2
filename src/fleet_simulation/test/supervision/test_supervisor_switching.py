"""The supervisor lets robots go before a late one, if switching is enabled."""
from __future__ import annotations

from random import Random
from typing import List

import pytest
from fleet_builders import AGV, graph_of, ladder

from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.standstills import Standstills
from trajectory_graph import Graph
from world.supervised_fleet import SupervisedFleet


def crossing() -> Graph:
    """Roads from 1 to 7 and from 11 to 17, which cross at vertex 4, a little nearer to 1."""
    places = {k: (2.5 * (k - 4), 0.0) for k in range(1, 8)}
    places.update({10 + k: (0.0, 2.6 * (k - 4)) for k in range(1, 8) if k != 4})
    across = [11, 12, 13, 4, 15, 16, 17]
    ends = {k: (k, k + 1) for k in range(1, 7)}
    ends.update({10 + k: pair for k, pair in enumerate(zip(across, across[1:]), 1)})
    return graph_of(places, ends)


def ended(fleet: SupervisedFleet) -> List[int]:
    """The missions that succeeded, in order."""
    return [status.request_id for status in fleet.statuses
            if status.state is MissionState.SUCCEEDED]


def both_cross(switches: bool) -> SupervisedFleet:
    """By the plan, robot a reaches the crossing first, but it stands for a minute before it."""
    fleet = SupervisedFleet(crossing(), {'a': (AGV, 1), 'b': (AGV, 11)}, switches=switches)
    fleet.request(1, 7, robot='a')
    fleet.request(2, 17, robot='b')
    fleet.run(2.0)
    fleet.agvs['a'].stalled = 60.0
    fleet.run_until_done(1, 2)
    return fleet


def test_a_robot_waits_for_a_late_one_that_goes_first_by_the_plan():
    assert both_cross(switches=False).statuses[-1].request_id == 2


def test_a_robot_goes_before_a_late_one_where_the_order_may_be_switched():
    fixed, switching = both_cross(switches=False), both_cross(switches=True)
    assert ended(switching) == [2, 1]
    assert switching.now < fixed.now
    assert switching.nearest >= 0.0


@pytest.mark.parametrize('seed', range(6))
def test_a_fleet_with_stalls_serves_all_and_comes_near_nobody_while_its_order_is_switched(seed):
    random = Random(seed)
    starts = random.sample((1, 3, 5, 7, 101, 103, 105, 107), 5)
    fleet = SupervisedFleet(ladder(7), {f'r{k}': (AGV, v) for k, v in enumerate(starts)},
                            seed=seed, switches=True)
    for number in range(1, 21):
        fleet.request(number, random.choice((1, 3, 5, 7, 101, 103, 105, 107)))
        fleet.run(random.uniform(0.0, 6.0))
        fleet.agvs[f'r{random.randrange(5)}'].stalled = random.choice((0.0, 10.0, 30.0))
    fleet.run_until_done(*range(1, 21), limit=900.0)
    assert fleet.nearest >= 0.0


def test_how_long_a_robot_will_stand_is_learned_from_how_long_robots_stood():
    fleet = SupervisedFleet(ladder(7), {'a': (AGV, 1)})
    robot, standstills = fleet.supervisor.robots['a'], Standstills()

    def stands(seconds: float) -> float:
        """The expected further standstill, in s, after a standstill of the given seconds."""
        robot.liveness._moved = fleet.now + 100.0 - seconds
        robot.liveness.seen = fleet.now + 100.0
        return standstills.further(robot, fleet.now + 100.0)

    fleet.run(60.0)
    assert standstills.further(robot, fleet.now) == 0.0
    fleet.request(1, 7)
    fleet.run(0.3)
    assert standstills.further(robot, fleet.now) == 0.0  # an edge has just been released to it
    assert stands(1.0) == 0.0 and stands(4.0) == 4.0  # no experience yet: the same time again
    for _ in range(6):
        stands(20.0)
        stands(0.0)
    assert stands(5.0) == pytest.approx(15.0)
    assert stands(30.0) == 30.0  # longer than any standstill before
