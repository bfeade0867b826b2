"""Frames of a robot on the floor."""
from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import Pose, Transform
from hypothesis import given
from hypothesis import strategies as st

from node_lifecycle.headings import quaternion_from_yaw, yaw_from_quaternion
from omron_ld90.nodes.support import poses

coordinates = st.floats(-100.0, 100.0)
angles = st.floats(-3.1, 3.1)


def pose(x: float, y: float, yaw: float) -> Pose:
    result = Pose(orientation=quaternion_from_yaw(yaw))
    result.position.x, result.position.y = x, y
    return result


def transform(x: float, y: float, yaw: float) -> Transform:
    result = Transform(rotation=quaternion_from_yaw(yaw))
    result.translation.x, result.translation.y = x, y
    return result


def seen_from_map(odom: Pose, x: float, y: float) -> tuple[float, float]:
    """Returns the map coordinates of the point (x, y) in the frame whose pose is `odom`."""
    yaw = yaw_from_quaternion(odom.orientation)
    return (odom.position.x + x * math.cos(yaw) - y * math.sin(yaw),
            odom.position.y + x * math.sin(yaw) + y * math.cos(yaw))


@given(coordinates, coordinates, angles, coordinates, coordinates, angles)
def test_odometry_hung_below_the_map_puts_the_robot_where_it_says_it_is(x, y, yaw, ox, oy, oyaw):
    odom = poses.map_to_odom(pose(x, y, yaw), transform(ox, oy, oyaw))
    assert seen_from_map(odom, ox, oy) == pytest.approx((x, y), abs=1e-9)
    turned = yaw_from_quaternion(odom.orientation) + oyaw - yaw
    assert math.cos(turned) == pytest.approx(1.0)


@pytest.mark.parametrize('x, y, yaw', [(0.0, 0.0, 0.0), (-2e6, 2e6, 3.0)])
def test_a_robot_can_be_anywhere_on_a_map(x, y, yaw):
    assert poses.is_plausible(pose(x, y, yaw))


@pytest.mark.parametrize('wrong', [
    pose(math.nan, 0.0, 0.0), pose(0.0, math.inf, 0.0), pose(1e305, 0.0, 0.0),
    pose(0.0, 0.0, math.nan), Pose()])
def test_no_robot_is_nowhere_or_beyond_every_map(wrong):
    assert not poses.is_plausible(wrong)
