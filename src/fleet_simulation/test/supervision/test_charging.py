"""Robots charge on request or when idle: who charges first, how long, and with which claim."""
from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import Mapping, Sequence

import pytest
from fleet_builders import AGV, corridor, graph_of, with_docks
from proofs import is_whole

from fleet_core.supervision.hindrances import Hindrance
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.waits import Wait, WaitCode
from fleet_core.supervision.why import mission_reason, robot_wait
from fleet_core.work.chargers import Charger
from fleet_core.work.devices import Device, DeviceKind
from fleet_core.work.site_work import SiteWork
from world.supervised_fleet import SupervisedFleet

LIVES = 6 if is_whole(__file__) else 2


def yard(robots: Mapping[str, int], docks: Sequence[int] = (6,),
         idle_below: float = 0.0) -> SupervisedFleet:
    """Returns a fleet that charges at `docks` of a corridor with a siding at vertex 3.

    robots -- the vertex on which each robot begins, by the name of the robot
    """
    kind = replace(AGV, docks=frozenset(docks))
    fleet = SupervisedFleet(with_docks(corridor(6, siding_at=3), *docks),
                            {name: (kind, vertex) for name, vertex in robots.items()},
                            settings=RobotSettings(idle_below=idle_below))
    fleet.run(1.0)
    return fleet


def charge(fleet: SupervisedFleet, **charges: float) -> None:
    for name, level in charges.items():
        fleet.do(fleet.supervisor.battery(name, level, fleet.now))
    fleet.run(0.5)


def ask(fleet: SupervisedFleet, name: str, until: float) -> str:
    problem, actions = fleet.supervisor.charge(name, until, fleet.now)
    fleet.do(actions)
    return problem


def stands_at(fleet: SupervisedFleet, name: str, vertex: int) -> bool:
    return fleet.supervisor.robots[name].stands_at((vertex,))


def test_a_robot_that_is_asked_to_charges_until_then_and_gets_no_mission_before() -> None:
    fleet = yard({'a': 4})
    charge(fleet, a=0.7)
    assert ask(fleet, 'a', 0.95) == ''
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    charge(fleet, a=0.9)
    fleet.request(1, 2)
    fleet.run(3.0)
    assert fleet.state(1) is MissionState.PENDING
    charge(fleet, a=0.95)
    fleet.run_until_done(1)


def test_a_robot_that_is_asked_to_charge_ends_its_mission_first() -> None:
    fleet = yard({'a': 4})
    charge(fleet, a=0.7)
    fleet.request(1, 1)
    fleet.run(2.0)
    assert ask(fleet, 'a', 0.9) == ''
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))


def test_a_request_to_charge_survives_a_restart_and_can_be_ended() -> None:
    fleet = yard({'a': 4})
    charge(fleet, a=0.7)
    ask(fleet, 'a', 0.9)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    fleet.restart()
    fleet.run(2.0)
    charge(fleet, a=0.85)
    fleet.request(1, 2)
    fleet.run(3.0)
    assert fleet.state(1) is MissionState.PENDING
    assert ask(fleet, 'a', 0.0) == ''
    fleet.run_until_done(1)


def test_a_request_to_charge_that_makes_no_sense_is_refused() -> None:
    fleet = yard({'a': 4})
    charge(fleet, a=0.7)
    assert ask(fleet, 'a', 0.6) == 'its charge is 70 % already'
    assert ask(fleet, 'a', 1.5) == 'it cannot charge until 150 %'
    assert 'no dock' in ask(yard({'a': 4}, docks=()), 'a', 0.9)


def test_a_robot_with_nothing_to_do_charges_and_yields_to_a_mission() -> None:
    fleet = yard({'a': 4}, idle_below=0.75)
    charge(fleet, a=0.7)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    fleet.request(1, 2)
    fleet.run(1.0)
    assert fleet.state(1) is MissionState.ACTIVE
    fleet.run_until_done(1)


def test_a_robot_with_nothing_to_do_gives_its_dock_to_one_that_must_charge() -> None:
    fleet = yard({'a': 5, 'b': 1}, idle_below=0.75)
    charge(fleet, a=0.7, b=0.9)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    charge(fleet, a=0.7, b=0.2)
    fleet.run_until(lambda: stands_at(fleet, 'b', 6))
    assert fleet.supervisor.robots['a'].dock is None


def test_a_robot_with_enough_charge_does_not_charge_while_it_has_nothing_to_do() -> None:
    fleet = yard({'a': 4}, idle_below=0.75)
    charge(fleet, a=0.76)
    fleet.run(20.0)
    assert stands_at(fleet, 'a', 4)


def test_a_mission_to_a_dock_in_use_gets_no_robot_that_would_only_wait_before_it() -> None:
    fleet = yard({'a': 5, 'b': 1})
    charge(fleet, a=0.2, b=0.9)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    fleet.request(1, 6, robot='b')
    fleet.run(5.0)
    mission = fleet.supervisor.book.find(1)
    assert mission is not None and fleet.state(1) is MissionState.PENDING
    reason = mission_reason(mission, fleet.supervisor, fleet.now)
    assert reason.wait == Wait(WaitCode.RESOURCE, 'charger dock_6 is in use by a, which charges '
                               'until 80 %')
    assert {one.robot: one.hindrance for one in reason.robots}['b'] is Hindrance.FULL
    assert stands_at(fleet, 'b', 1)
    charge(fleet, a=0.85)
    fleet.run_until_done(1)
    assert stands_at(fleet, 'b', 6)


def test_a_mission_to_a_dock_waits_for_the_mission_there_and_for_a_robot_out_of_service() -> None:
    fleet = yard({'a': 5, 'b': 1})
    fleet.request(1, 6, robot='a', dwells=(30.0,))
    fleet.run(1.0)
    fleet.request(2, 6, robot='b')
    fleet.run(15.0)
    assert fleet.supervisor.book.find(2).reason == (
        'charger dock_6 is in use by a, which serves mission 1')
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(2.0)
    assert fleet.supervisor.book.find(2).reason == (
        'charger dock_6 is in use by a, which is not in service')


def test_a_mission_to_a_dock_where_a_robot_only_tops_up_gets_a_robot() -> None:
    fleet = yard({'a': 5, 'b': 1}, idle_below=0.75)
    charge(fleet, a=0.7, b=0.9)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    fleet.request(1, 6, robot='b')
    fleet.run_until_done(1)


@pytest.mark.parametrize('seed', range(LIVES))
def test_no_two_robots_get_one_dock_and_none_waits_for_one_that_need_not_charge(seed: int) -> None:
    draw = Random(seed)
    fleet = yard({'a': 1, 'b': 4, 'c': 5}, docks=(1, 6), idle_below=0.75)
    for id in range(1, 30):
        name = draw.choice('abc')
        charge(fleet, **{name: draw.choice((0.2, 0.5, 0.7, 0.85))})
        if draw.random() < 0.3:
            fleet.request(id, draw.choice((2, 3, 4)))
        if draw.random() < 0.2:
            ask(fleet, draw.choice('abc'), draw.choice((0.0, 0.9)))
        fleet.run(draw.uniform(0.0, 6.0))
        robots = fleet.supervisor.robots.values()
        docks = [robot.dock for robot in robots if robot.dock is not None]
        assert len(docks) == len(set(docks))
        waiting = fleet.supervisor.charging.waiting
        assert not waiting or not any(robot.tops_up for robot in robots)
        assert all(robot.dock is not None for robot in robots if robot.tops_up)


# -- chargers are claimed --------------------------------------------------------------------------

# A lane with a bay of two docks at its end, and a dock at its beginning:
#
#     5 -- 1 -- 2 -- 3 -- 4 -- 6
#               |    |     \
#               8    9      7
BAYS = with_docks(graph_of(
    {**{k: (3.0 * k, 0.0) for k in (1, 2, 3, 4)}, 5: (0.0, 0.0), 6: (15.0, 0.0), 7: (14.0, 3.0),
     8: (6.0, 3.0), 9: (9.0, 3.0)},
    {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (1, 5), 5: (4, 6), 6: (4, 7), 7: (2, 8), 8: (3, 9)}),
    5, 6, 7)


def lane(robots: Mapping[str, int], *chargers: Charger, docks: Sequence[int] = (5, 6, 7),
         idle_below: float = 0.0, doors: Sequence[Device] = ()) -> SupervisedFleet:
    kind = replace(AGV, docks=frozenset(docks))
    fleet = SupervisedFleet(
        BAYS, {name: (kind, vertex) for name, vertex in robots.items()},
        settings=RobotSettings(idle_below=idle_below), dock_approach=0.5,
        work=SiteWork(chargers={one.name: one for one in chargers},
                      devices={one.name: one for one in doors}))
    fleet.run(1.0)
    return fleet


def holders(fleet: SupervisedFleet, charger: str) -> Sequence[str]:
    return fleet.supervisor.interlocking.claims.holders(charger)


def test_a_charger_is_claimed_before_the_last_edge_and_until_the_robot_has_left_it() -> None:
    fleet = lane({'a': 4}, docks=(6,))
    charge(fleet, a=0.2)
    claims = fleet.supervisor.interlocking.claims
    fleet.run_until(lambda: 5 in fleet.supervisor.robots['a'].record.ahead)
    assert holders(fleet, 'dock_6') == ['a'] and claims.stored_of('a') == {'dock_6'}
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    charge(fleet, a=0.9)
    fleet.run(5.0)
    assert holders(fleet, 'dock_6') == ['a']
    fleet.request(1, 9)
    fleet.run_until_done(1)
    assert holders(fleet, 'dock_6') == []


def test_a_robot_waits_for_a_charger_and_says_who_has_it() -> None:
    fleet = lane({'a': 4, 'b': 3}, docks=(6,))
    charge(fleet, a=0.1, b=0.2)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    robot, supervisor = fleet.supervisor.robots['b'], fleet.supervisor
    wait = robot_wait(robot, supervisor.errand(robot), supervisor, fleet.now)
    assert (wait.code, wait.text) == (WaitCode.CHARGING, 'a charger: dock_6 (a)')
    charge(fleet, a=0.9)
    fleet.run_until(lambda: stands_at(fleet, 'b', 6))


def test_a_bay_for_one_robot_charges_one_after_the_other_also_past_a_parked_one() -> None:
    fleet = lane({'a': 6, 'b': 3, 'c': 2}, Charger('bay', (6, 7), 1), docks=(6, 7))
    charge(fleet, a=0.9, b=0.1, c=0.2)
    fleet.run_until(lambda: any(stands_at(fleet, 'b', dock) for dock in (6, 7)))
    assert holders(fleet, 'bay') == ['b']
    assert fleet.supervisor.charging.waiting == {'c': 'a charger: bay (b)'}
    charge(fleet, b=0.9, c=0.2)
    fleet.run_until(lambda: any(stands_at(fleet, 'c', dock) for dock in (6, 7)))
    assert holders(fleet, 'bay') == ['c']


def test_another_charger_is_chosen_when_one_that_cannot_work_stays_in_the_nearest() -> None:
    fleet = lane({'a': 1, 'b': 6}, docks=(6, 7))
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    charge(fleet, a=0.2, b=0.9)
    fleet.run_until(lambda: stands_at(fleet, 'a', 7))


def test_a_charger_behind_a_door_that_does_not_work_is_not_chosen() -> None:
    fleet = lane({'a': 3}, docks=(5, 6), doors=[Device('gate', DeviceKind.DOOR, (5,), 10.0)])
    fleet.devices['gate'].is_silent = True
    fleet.run(5.0)
    charge(fleet, a=0.2)
    assert fleet.supervisor.robots['a'].dock == 5
    fleet = lane({'a': 3}, docks=(6,), doors=[Device('gate', DeviceKind.DOOR, (5,), 10.0)])
    fleet.devices['gate'].is_silent = True
    fleet.run(5.0)
    charge(fleet, a=0.2)
    assert fleet.supervisor.charging.waiting == {
        'a': 'a charger: the door gate on the way there does not work'}
    fleet.devices['gate'].is_silent = False
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))


def test_a_robot_with_nothing_to_do_gives_its_dock_to_a_mission_that_goes_there() -> None:
    fleet = lane({'a': 4, 'b': 2}, docks=(6,), idle_below=0.75)
    charge(fleet, a=0.7, b=0.9)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    fleet.request(1, 6, robot='b', dwells=(3.0,))
    fleet.run_until_done(1, limit=200.0)


def test_after_a_restart_a_robot_with_nothing_to_do_still_yields() -> None:
    fleet = lane({'a': 4}, docks=(6,), idle_below=0.75)
    charge(fleet, a=0.7)
    fleet.run_until(lambda: stands_at(fleet, 'a', 6))
    fleet.restart()
    fleet.run(2.0)
    assert fleet.supervisor.robots['a'].tops_up and holders(fleet, 'dock_6') == ['a']
    fleet.request(1, 9)
    fleet.run_until_done(1)
