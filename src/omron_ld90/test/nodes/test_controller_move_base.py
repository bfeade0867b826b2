"""Poses become whole millimetres and degrees, or are refused with a reason."""
from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import PoseStamped

from omron_ld90.nodes.controller_actions import Refused
from omron_ld90.nodes.controller_move_base import robot_pose


def pose(x: float = 1.0, y: float = 2.0, yaw: float = 0.0, frame: str = 'map') -> PoseStamped:
    stamped = PoseStamped()
    stamped.header.frame_id = frame
    stamped.pose.position.x, stamped.pose.position.y = x, y
    stamped.pose.orientation.z, stamped.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return stamped


def test_a_pose_becomes_whole_millimetres_and_degrees():
    assert robot_pose(pose(1.2345, -2.0, math.radians(-90)), 'map') == (1234, -2000, -90)


@pytest.mark.parametrize(('bad', 'reason'), [
    (pose(frame='odom'), '"odom"'), (pose(frame=''), '""'), (pose(x=math.nan), 'finite'),
    (pose(y=math.inf), 'finite'), (pose(x=1e9), 'away'), (PoseStamped(), 'frame'),
])
def test_a_pose_that_is_none_is_refused(bad, reason):
    with pytest.raises(Refused, match=reason):
        robot_pose(bad, 'map')


def test_an_orientation_that_is_none_is_refused():
    bad = pose()
    bad.pose.orientation.w = 0.0
    with pytest.raises(Refused, match='unit quaternion'):
        robot_pose(bad, 'map')
