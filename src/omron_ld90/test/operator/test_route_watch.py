"""The decision whether the fleet manager drives the robot, and which route to show."""
from __future__ import annotations

import pytest

from omron_ld90.operator.route_watch import (
    SHOWN_AFTER_THE_END,
    SILENCE,
    EdgeProgress,
    RouteView,
    RouteWatch,
)
from route_protocol.values import EdgeState

DONE, DRIVING, FAILED = EdgeState.COMPLETE, EdgeState.PROCESSING, EdgeState.FAILED


def test_a_route_with_an_edge_to_go_is_running():
    routes = RouteWatch()
    routes.update(7, [DONE, DRIVING, DRIVING], now=10.0)
    assert routes.running(10.1) == 7


@pytest.mark.parametrize('edges', [[DONE, DONE], [DONE, FAILED, DRIVING], []])
def test_a_route_that_is_complete_failed_or_stopped_is_not_running(edges):
    routes = RouteWatch()
    routes.update(7, [DRIVING, DRIVING], now=10.0)
    routes.update(7, edges, now=10.1)
    assert routes.running(10.2) is None


def test_the_refusal_of_another_route_leaves_the_running_one_alone():
    routes = RouteWatch()
    routes.update(7, [DRIVING], now=10.0)
    routes.update(8, [FAILED, FAILED], now=10.05)
    assert routes.running(10.1) == 7


def test_a_route_that_is_not_heard_of_any_more_does_not_block_clicks():
    routes = RouteWatch()
    routes.update(7, [DRIVING], now=10.0)
    assert routes.running(10.0 + SILENCE) == 7
    assert routes.running(10.1 + SILENCE) is None


def test_nothing_runs_before_anything_was_heard():
    assert RouteWatch().running(0.0) is None


def test_a_refusal_while_nothing_runs_is_not_ignored():
    assert RouteWatch().update(8, [FAILED], now=10.0)


def route(*states: int) -> list:
    return [EdgeProgress(edge, state) for edge, state in enumerate(states, start=1)]


def test_a_route_is_shown_anew_only_when_an_edge_changes():
    view = RouteView()
    assert view.update(7, route(DRIVING, DRIVING), now=10.0)
    assert not view.update(7, route(DRIVING, DRIVING), now=10.1)
    assert view.update(7, route(DONE, DRIVING), now=10.2)
    assert list(view.shown) == route(DONE, DRIVING)


def test_a_refused_route_does_not_replace_the_one_being_driven():
    view = RouteView()
    view.update(7, route(DRIVING), now=10.0)
    assert not view.update(8, route(FAILED, FAILED), now=10.05)
    assert list(view.shown) == route(DRIVING)


def test_a_route_that_ended_is_seen_for_a_while_and_does_not_come_back():
    view = RouteView()
    view.update(7, route(DONE), now=10.0)
    assert not view.expire(10.0 + SHOWN_AFTER_THE_END - 0.1)
    assert view.expire(10.0 + SHOWN_AFTER_THE_END)
    assert view.shown == ()
    assert not view.update(7, route(DONE), now=11.0 + SHOWN_AFTER_THE_END)
    assert not view.expire(12.0 + SHOWN_AFTER_THE_END)
    assert view.shown == ()


def test_a_route_being_driven_does_not_expire():
    view = RouteView()
    view.update(7, route(DRIVING), now=10.0)
    later = 10.0 + 2 * SHOWN_AFTER_THE_END
    view.update(7, route(DRIVING), now=later)
    assert not view.expire(later)
