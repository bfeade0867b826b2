"""After a start, the log says once which robots are ready."""
from __future__ import annotations

from fleet_core.supervision.fleet_view import RobotState
from fleet_core.supervision.readiness import LIMIT, Readiness

IDLE, BUSY = RobotState.IDLE, RobotState.BUSY


def test_a_start_tells_once_that_all_robots_are_ready() -> None:
    readiness = Readiness()
    assert readiness.words({'a': RobotState.OFFLINE, 'b': BUSY}, True, False, 10.0) == ''
    assert readiness.words({}, True, False, 11.0) == ''
    assert readiness.words({'a': BUSY, 'b': RobotState.OFF_GRAPH}, True, False, 11.5) == ''
    robots = {'a': BUSY, 'b': IDLE, 'c': RobotState.ABSENT}
    assert readiness.words(robots, False, False, 12.0) == '', 'the graph is being surveyed'
    assert readiness.words(robots, True, False, 12.5) == 'Ready: 2 robots.'
    assert readiness.words(robots, True, False, 13.0) == ''


def test_a_robot_that_is_not_ready_is_named_after_a_while() -> None:
    readiness, robots = Readiness(), {'a': BUSY, 'b': RobotState.UNKNOWN}
    assert readiness.words(robots, True, True, 10.0) == ''
    assert readiness.words(robots, True, True, 10.0 + LIMIT) == (
        'Ready: 1 robot. Not ready: b (place unknown). The fleet is stopped: press Go on.')
