"""The motion of a simulated AGV."""
from __future__ import annotations

import math

import pytest
from fleet_builders import graph_of

from fleet_simulation.agv.drive import AgvMotion
from fleet_simulation.agv.speed_limits import DriveLimits, SpeedLimits
from trajectory_graph import CurveType, Edge, Graph, Vertex

STEP = 0.05  # s
LIMITS = DriveLimits(speed=1.0, acceleration=0.5, braking=0.5, turn_rate=1.0)
STRAIGHT = graph_of({1: (0, 0), 2: (4, 0), 3: (8, 0), 4: (8, 3)}, {1: (1, 2), 2: (2, 3), 3: (3, 4)})


def drive_on(graph: Graph, vertex: int, limits: DriveLimits = LIMITS) -> AgvMotion:
    return AgvMotion(graph, limits, SpeedLimits(graph, limits), vertex)


def time_to_end(drive: AgvMotion) -> float:
    seconds = 0.0
    while not drive.at_end:
        drive.advance(STEP)
        seconds += STEP
        assert seconds < 1000.0, f'the AGV did not arrive: {drive.pose}'
    return seconds


def test_it_accelerates_drives_and_brakes_as_stated() -> None:
    drive = drive_on(STRAIGHT, 1)
    drive.follow((1, 2), 0, 0.0)
    assert time_to_end(drive) == pytest.approx(8.0 / 1.0 + 1.0 / 0.5, abs=0.2)
    assert drive.pose == pytest.approx((8.0, 0.0, 0.0))
    assert drive.vertex == 3


def test_it_does_not_slow_down_between_edges_that_run_on() -> None:
    drive = drive_on(STRAIGHT, 1)
    drive.follow((1, 2), 0, 0.0)
    while drive.index == 0:
        drive.advance(STEP)
    assert drive.speed == pytest.approx(1.0)


def test_speed_never_changes_faster_than_the_drive_can() -> None:
    drive = drive_on(STRAIGHT, 1)
    drive.follow((1, 2, 3), 0, 0.0)
    before = 0.0
    while not drive.at_end:
        drive.advance(STEP)
        assert -0.5 * STEP - 0.03 <= drive.speed - before <= 0.5 * STEP + 1e-9
        before = drive.speed


def test_it_stands_at_a_corner_and_turns_there() -> None:
    drive = drive_on(STRAIGHT, 2)
    drive.follow((2, 3), 0, 0.0)
    while drive.index == 0:
        drive.advance(STEP)
    assert (drive.pose, drive.speed) == (pytest.approx((8.0, 0.0, 0.0)), 0.0)
    drive.advance(0.5)
    x, y, heading = drive.pose
    assert (x, y) == (8.0, 0.0)
    assert 0.1 < heading < math.pi / 2
    time_to_end(drive)
    assert drive.pose == pytest.approx((8.0, 3.0, math.pi / 2))


def test_it_drives_back_with_its_rear_ahead() -> None:
    drive = drive_on(STRAIGHT, 2)
    drive.follow((2, -2), 0, 0.0)
    time_to_end(drive)
    assert drive.pose == pytest.approx((4.0, 0.0, 0.0))


def test_a_bend_is_driven_no_faster_than_it_can_turn() -> None:
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 0.6, 0.6, math.pi / 2)],
                  # on a curve with a radius of about 0.6 m
                  [Edge(1, 1, 2, CurveType.SPLINE, 0.33, 0.33, 1.0, 1.0)])
    drive = drive_on(graph, 1)
    drive.follow((1,), 0, 0.0)
    while not drive.at_end:
        before = drive.heading
        drive.advance(0.5)
        assert abs(drive.heading - before) <= LIMITS.turn_rate * 0.5 * 1.1
    assert drive.pose == pytest.approx((0.6, 0.6, math.pi / 2), abs=0.02)


def test_an_edge_is_driven_at_its_own_speed() -> None:
    slow = graph_of({1: (0, 0), 2: (3, 0)}, {1: (1, 2)}, speed=0.3)
    drive = drive_on(slow, 1)
    drive.follow((1,), 0, 0.0)
    assert time_to_end(drive) == pytest.approx(3.0 / 0.3 + 0.3 / 0.5, abs=0.2)


def test_held_it_brakes_and_goes_on_from_there() -> None:
    drive = drive_on(STRAIGHT, 1)
    drive.follow((1, 2), 0, 0.0)
    drive.advance(3.0)
    x = drive.pose[0]
    drive.advance(5.0, hold=True)
    assert drive.at_rest
    assert drive.pose[0] == pytest.approx(x + 1.0, abs=0.06)  # braking distance v^2 / 2b
    time_to_end(drive)
    assert drive.vertex == 3


def test_an_emergency_brake_is_harder() -> None:
    drive = drive_on(STRAIGHT, 1)
    drive.follow((1, 2), 0, 0.0)
    drive.advance(3.0)
    x = drive.pose[0]
    drive.advance(5.0, hold=True, emergency=True)
    assert drive.pose[0] == pytest.approx(x + 0.25, abs=0.06)


def test_it_knows_where_it_can_stop_no_more() -> None:
    drive = drive_on(STRAIGHT, 1)
    drive.follow((1, 2), 0, 0.0)
    while drive.arc < 2.9:
        drive.advance(STEP)
    assert drive.can_follow((1,), 0, drive.arc)
    while drive.arc < 3.2:
        drive.advance(STEP)
    assert not drive.can_follow((1,), 0, drive.arc)
    assert drive.can_follow((1, 2), 0, drive.arc)
