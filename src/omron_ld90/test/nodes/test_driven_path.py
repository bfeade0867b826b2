"""The recorded path of the robot."""
from __future__ import annotations

from geometry_msgs.msg import PoseStamped

from omron_ld90.nodes.driven_path import JUMP, DrivenPath


def at(x: float) -> PoseStamped:
    pose = PoseStamped()
    pose.pose.position.x = x
    return pose


def kept(path: DrivenPath) -> list:
    return [pose.pose.position.x for pose in path.message.poses]


def test_poses_that_are_no_step_apart_are_left_out():
    path = DrivenPath('map', 10, step=0.1)
    assert [path.add(at(x)) for x in (0.0, 0.05, 0.2)] == [True, False, True]
    assert kept(path) == [0.0, 0.2]


def test_the_oldest_poses_go_when_there_are_too_many():
    path = DrivenPath('map', 3, step=0.1)
    for x in range(5):
        path.add(at(float(x)))
    assert kept(path) == [2.0, 3.0, 4.0]


def test_the_path_begins_anew_where_the_robot_was_relocalised():
    path = DrivenPath('map', 10, step=0.1)
    for x in (0.0, 1.0, 1.0 + JUMP + 0.1):
        path.add(at(x))
    assert kept(path) == [1.0 + JUMP + 0.1]


def test_a_cleared_path_keeps_its_frame():
    path = DrivenPath('map', 10, step=0.1)
    path.add(at(0.0))
    path.clear()
    assert kept(path) == [] and path.message.header.frame_id == 'map'
