"""/fleet_poses has the last location of each robot; tested without a ROS master."""
import math
from unittest.mock import patch

import pytest

rospy = pytest.importorskip('rospy')
genpy = pytest.importorskip('genpy')

from graph_fleet_manager.nodes import fleet_poses  # noqa: E402
from itrci_nav_msgs.msg import ExecutionRouteStates  # noqa: E402


@pytest.fixture
def topic():
    with patch.object(fleet_poses.rospy, 'Publisher'), patch.object(fleet_poses, 'Periodic'):
        yield fleet_poses.FleetPosesTopic(['a', 'b'])


def report(x, y, second, theta=0.5):
    message = ExecutionRouteStates(x=x, y=y, theta=theta)
    message.header.stamp = genpy.Time(second)
    return message


def told(topic):
    message = topic.message(genpy.Time(9))
    assert message.header.frame_id == 'map' and message.header.stamp == genpy.Time(9)
    return {pose.robot: pose for pose in message.poses}


def test_a_robot_without_a_report_has_no_place(topic):
    assert all(math.isnan(pose.x) and pose.seen == genpy.Time(0) for pose in told(topic).values())


def test_the_last_location_is_told_with_its_time(topic):
    topic.note('a', report(1.0, 2.0, 5))
    pose = told(topic)['a']
    assert (pose.x, pose.y, pose.theta, pose.seen) == (1.0, 2.0, 0.5, genpy.Time(5))
    assert math.isnan(told(topic)['b'].x)


def test_a_report_without_a_location_changes_nothing(topic):
    topic.note('a', report(1.0, 2.0, 5))
    topic.note('a', report(math.nan, 2.0, 6))
    assert told(topic)['a'].x == 1.0
