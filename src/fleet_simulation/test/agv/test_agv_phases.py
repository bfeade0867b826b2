"""The motion of a simulated AGV in closed form, and a robot whose motion is simulated only when
due.
"""
from __future__ import annotations

import math
from random import Random
from typing import List, Tuple

import pytest
from fleet_builders import graph_of
from hypothesis import given
from hypothesis import strategies as st

from fleet_core.fleet import RobotType
from fleet_simulation.agv import phases
from fleet_simulation.agv.drive import AgvMotion
from fleet_simulation.agv.speed_limits import DriveLimits, SpeedLimits
from fleet_simulation.driven_robot import AGV, Delays, DrivenRobot, RandomStops
from route_protocol.values import RouteOrder

CORNERS = graph_of({1: (0, 0), 2: (4, 0), 3: (8, 0), 4: (8, 3)}, {1: (1, 2), 2: (2, 3), 3: (3, 4)})
STRETCHES = st.lists(st.tuples(st.floats(0.01, 5.0), st.floats(0.05, 2.0)), min_size=1, max_size=6)
ACCELERATION, BRAKING = 0.5, 0.2


@given(STRETCHES)
def test_a_drive_keeps_all_limits_and_stands_at_its_end(
        stretches: List[Tuple[float, float]]) -> None:
    found = phases.along(stretches, 0.0, ACCELERATION, BRAKING)
    driven, speed = 0.0, 0.0
    for phase in found:
        assert phase.speed == pytest.approx(speed, abs=1e-6)
        middle = driven + phase.distance_after(phase.seconds / 2.0)
        speed = phase.speed_after(phase.seconds)
        driven += phase.distance_after(phase.seconds)
        assert phase.gain in (ACCELERATION, 0.0, -BRAKING)
        assert max(phase.speed, speed) <= limit_at(stretches, middle) + 1e-6
    assert driven == pytest.approx(sum(length for length, _ in stretches))
    assert speed == pytest.approx(0.0, abs=1e-3)


def limit_at(stretches: List[Tuple[float, float]], arc: float) -> float:
    for length, limit in stretches:
        if arc <= length:
            return limit
        arc -= length
    return stretches[-1][1]


@given(STRETCHES, st.floats(0.0, 1.0))
def test_a_point_is_passed_at_the_time_that_is_told(
        stretches: List[Tuple[float, float]], part: float) -> None:
    found = phases.along(stretches, 0.0, ACCELERATION, BRAKING)
    wanted = part * sum(length for length, _ in stretches) * (1.0 - 1e-9)
    left, driven = phases.seconds_until(found, wanted), 0.0
    for phase in found:
        seconds = min(left, phase.seconds)
        driven, left = driven + phase.distance_after(seconds), left - seconds
    assert driven == pytest.approx(wanted, abs=1e-6)


def test_a_drive_that_is_too_fast_for_a_limit_brakes() -> None:
    found = phases.along([(5.0, 0.5)], 1.0, ACCELERATION, BRAKING)
    assert found[0] == phases.DrivePhase(pytest.approx(2.5), 1.0, -BRAKING)


@given(st.lists(st.floats(0.01, 3.0), min_size=1, max_size=20))
def test_it_does_not_matter_in_which_parts_the_time_passes(parts: List[float]) -> None:
    one, other = (motion_on((1, 2, 3, -3)) for _ in range(2))
    for seconds in parts:
        one.advance(seconds)
    other.advance(sum(parts))
    assert one.index == other.index
    assert one.arc == pytest.approx(other.arc, abs=1e-5)
    assert one.driven == pytest.approx(other.driven, abs=1e-5)
    assert math.cos(one.heading - other.heading) == pytest.approx(1.0)


def motion_on(path: Tuple[int, ...]) -> AgvMotion:
    limits = DriveLimits(reverses=False)
    drive = AgvMotion(CORNERS, limits, SpeedLimits(CORNERS, limits), 1)
    drive.follow(path, 0, 0.0)
    return drive


def test_a_robot_that_is_driven_only_when_it_is_due_is_where_another_one_is() -> None:
    one, other = (robot() for _ in range(2))
    driven = 0.0
    for step in range(1, 401):
        now = 0.1 * step
        one.drive(0.1)
        if other.due <= now:
            other.drive(now - driven)
            driven = now
        assert other.news == one.news, f'at {now} s'
    other.drive(40.0 - driven)
    assert other.position == pytest.approx(one.position, abs=1e-3)
    assert other.travelled == pytest.approx(11.0, abs=1e-3)


def robot() -> DrivenRobot:
    made = DrivenRobot('r', CORNERS, RobotType('agv', 0.3, 1.0), 1, AGV,
                       Delays(1.1, RandomStops(9.0, 2.0), RandomStops(11.0, 1.0)), Random(4), 1.0)
    made.receive(RouteOrder(1, (1, 2, 3)))
    return made
