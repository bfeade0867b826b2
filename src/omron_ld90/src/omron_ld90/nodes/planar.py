"""Frames of a robot that stays on the floor: x, y and yaw out of ROS's poses and transforms."""
from __future__ import annotations

import math

from geometry_msgs.msg import Pose, Transform

from omron_ld90.nodes.units import quaternion_from_yaw, yaw_from_quaternion


def map_to_odom(base_in_map: Pose, base_in_odom: Transform) -> Pose:
    """The pose of the odometry frame in the map that puts the robot's base at `base_in_map`."""
    yaw = yaw_from_quaternion(base_in_map.orientation) - yaw_from_quaternion(base_in_odom.rotation)
    odom = Pose()
    odom.orientation = quaternion_from_yaw(yaw)
    x, y = base_in_odom.translation.x, base_in_odom.translation.y
    odom.position.x = base_in_map.position.x - x * math.cos(yaw) + y * math.sin(yaw)
    odom.position.y = base_in_map.position.y - x * math.sin(yaw) - y * math.cos(yaw)
    return odom
