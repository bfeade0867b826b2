"""A motion as nav_msgs/Odometry: the frames of pose and twist, and the places of the variances."""
from __future__ import annotations

import pytest
import rospy
from geometry_msgs.msg import Pose

from omron_ld90.nodes.robot_state_publisher import odometry_of
from omron_ld90.odometry import MeanMotion

MOTION = MeanMotion(speed=0.5, turn_rate=-0.2, speed_variance=0.1, turn_rate_variance=0.2,
                    position_variance=0.3, yaw_variance=0.4)


@pytest.fixture
def message():
    pose = Pose()
    pose.position.x, pose.orientation.w = 3.0, 1.0
    return odometry_of(MOTION, pose, rospy.Time(12, 5), 'map', 'ld/base_link')


def test_the_pose_is_in_the_map_and_the_twist_in_the_robots_frame(message):
    assert (message.header.frame_id, message.child_frame_id) == ('map', 'ld/base_link')
    assert message.header.stamp == rospy.Time(12, 5)
    assert message.pose.pose.position.x == 3.0
    assert (message.twist.twist.linear.x, message.twist.twist.angular.z) == (0.5, -0.2)


def test_each_variance_stands_on_its_own_place_of_the_diagonal(message):
    pose, twist = message.pose.covariance, message.twist.covariance
    assert (pose[0], pose[7], pose[35]) == (0.3, 0.3, 0.4)
    assert (twist[0], twist[35]) == (0.1, 0.2)
    for matrix in (pose, twist):
        assert len(matrix) == 36
        assert all(matrix[i] > 0.0 for i in range(0, 36, 7))
        assert sum(value != 0.0 for value in matrix) == 6
