"""A click moves the robot, except when a fleet manager drives it."""
from __future__ import annotations

import pytest

from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    FleetRobot,
    FleetState,
)
from omron_ld90.nodes.support.click_rule import SILENCE, WITH_A_PERSON, ClickRule


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def rule(clock) -> ClickRule:
    return ClickRule('ld90_1', clock=clock)


def fleet(state: int = FleetRobot.IDLE, name: str = 'ld90_1') -> FleetState:
    return FleetState(robots=[FleetRobot(name='agv_1'), FleetRobot(name=name, state=state)])


def route(state: int) -> ExecutionRouteStates:
    return ExecutionRouteStates(route_id=7, edge_states=[EdgeState(edge_id=3, state=state)])


def test_without_a_fleet_a_click_moves_the_robot(rule):
    assert rule.refusal() is None
    assert not rule.asks_for_missions


def test_the_click_on_a_managed_robot_is_refused_with_the_command_to_use(rule):
    rule.on_fleet(fleet())
    assert rule.asks_for_missions
    assert 'mission VERTEX --robot ld90_1' in rule.refusal()
    assert 'fleet out ld90_1' in rule.refusal()


@pytest.mark.parametrize('state', sorted(WITH_A_PERSON))
def test_a_robot_that_was_left_to_a_person_obeys_clicks(rule, state):
    rule.on_fleet(fleet())
    rule.on_fleet(fleet(state))
    assert rule.refusal() is None


def test_other_robots_of_the_fleet_do_not_matter(rule):
    rule.on_fleet(fleet(name='ld90_10'))
    assert rule.refusal() is None


def test_a_fleet_manager_that_fell_silent_manages_nobody(rule, clock):
    rule.on_fleet(fleet())
    clock.now += SILENCE + 0.1
    assert rule.refusal() is None


def test_while_any_fleet_drives_a_route_a_click_is_refused(rule):
    rule.on_route(route(EdgeState.PROCESSING))
    assert rule.refusal() == 'Not sent: the fleet drives route 7. Stop it first.'
    assert not rule.asks_for_missions
    rule.on_route(route(EdgeState.COMPLETE))
    assert rule.refusal() is None


def test_whoever_allows_it_takes_the_robot_over_by_a_click(clock):
    rule = ClickRule('ld90_1', allow_takeover=True, clock=clock)
    rule.on_fleet(fleet())
    rule.on_route(route(EdgeState.PROCESSING))
    assert rule.refusal() is None
    assert not rule.asks_for_missions
