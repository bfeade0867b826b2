"""Charging on request and by opportunity: until when, and to whom it yields."""
from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import Mapping, Sequence

import pytest
from fleet_builders import AGV, corridor, with_docks

from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.settings import RobotSettings
from world.supervised_fleet import SupervisedFleet


def yard(robots: Mapping[str, int], docks: Sequence[int] = (6,),
         idle_below: float = 0.0) -> SupervisedFleet:
    """Robots {name: vertex} that charge at docks of a corridor with a siding at 3."""
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


@pytest.mark.parametrize('seed', range(6))
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
        assert 'a free dock' not in waiting.values() or not any(robot.tops_up for robot in robots)
        assert all(robot.dock is not None for robot in robots if robot.tops_up)
