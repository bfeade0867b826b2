"""Speed and turn rate from successive locations, and their uncertainty."""
from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omron_ld90 import robot_model
from omron_ld90.odometry import MAX_GAP, MotionMeter, TimedPose


def motion(*locations: TimedPose):
    """Returns the motion at the last of these locations."""
    odometer = MotionMeter()
    return [odometer.add(location) for location in locations][-1]


START = TimedPose(10.0, 1.0, 2.0, math.pi / 2)


def test_a_robot_that_drives_ahead_has_its_speed_whichever_way_it_faces():
    moved = motion(START, TimedPose(10.5, 1.0, 2.4, math.pi / 2))
    assert (moved.speed, moved.turn_rate) == (pytest.approx(0.8), 0.0)


def test_a_robot_that_drives_backwards_has_a_negative_speed():
    assert motion(START, TimedPose(10.5, 1.0, 1.9, math.pi / 2)).speed == pytest.approx(-0.2)


def test_a_turn_through_half_a_circle_is_the_short_one():
    moved = motion(TimedPose(0.0, 0.0, 0.0, math.radians(179.0)),
                   TimedPose(0.5, 0.0, 0.0, math.radians(-179.0)))
    assert moved.turn_rate == pytest.approx(math.radians(4.0))
    assert moved.speed == 0.0


@given(radius=st.floats(0.5, 20.0), yaw=st.floats(-3.1, 3.1), speed=st.floats(-1.2, 1.2),
       interval=st.floats(0.05, 0.5))
def test_on_an_arc_the_speed_is_that_along_the_arc(radius, yaw, speed, interval):
    turn = speed * interval / radius
    end = TimedPose(interval, radius * (math.sin(yaw + turn) - math.sin(yaw)),
                    radius * (math.cos(yaw) - math.cos(yaw + turn)), yaw + turn)
    moved = motion(TimedPose(0.0, 0.0, 0.0, yaw), end)
    assert moved.speed == pytest.approx(speed, abs=1e-9)
    assert moved.turn_rate == pytest.approx(speed / radius, abs=1e-9)


def test_the_first_location_tells_of_no_motion_and_nor_does_one_after_a_gap():
    assert motion(START) is None
    assert motion(START, TimedPose(10.0 + MAX_GAP + 0.1, 1.0, 2.0, 0.0)) is None


def test_a_location_that_is_no_newer_tells_of_no_motion():
    assert motion(START, START) is None
    assert motion(START, TimedPose(9.0, 1.0, 2.0, 0.0)) is None


@pytest.mark.parametrize('jump', [
    TimedPose(10.5, 9.0, 2.0, math.pi / 2), TimedPose(10.5, 1.0, 2.0 + 3.0, math.pi / 2),
    TimedPose(10.5, 1.3, 2.0, math.pi / 2)])
def test_a_robot_that_was_relocalised_did_not_drive_there(jump):
    assert motion(START, jump) is None
    after = TimedPose(jump.time + 0.5, jump.x, jump.y, jump.yaw)
    assert motion(START, jump, after).speed == 0.0


def test_at_full_speed_a_robot_is_believed():
    fast = TimedPose(10.1, 1.0, 2.0 + 0.1 * robot_model.TOP_SPEED, math.pi / 2)
    assert motion(START, fast).speed == pytest.approx(robot_model.TOP_SPEED)


def test_what_is_known_of_the_motion_gets_less_with_the_time_between_locations():
    def at(interval: float):
        return motion(START, TimedPose(10.0 + interval, 1.0, 2.0 + interval, math.pi / 2))

    often, seldom = at(0.5), at(1.9)
    assert seldom.speed_variance > often.speed_variance
    assert seldom.turn_rate_variance > often.turn_rate_variance
    assert seldom.position_variance > often.position_variance


def test_locations_in_quick_succession_leave_the_velocity_to_rounding():
    quick = motion(START, TimedPose(10.002, 1.0, 2.001, math.pi / 2))
    assert math.sqrt(quick.speed_variance) > abs(quick.speed)
