"""Converts poses between the robot's units (mm, degrees) and those of ROS (m, rad; REP 103)."""
from __future__ import annotations

import math
from typing import Tuple

from geometry_msgs.msg import Pose, Transform

from node_lifecycle.headings import quaternion_from_yaw, yaw_from_quaternion
from omron_ld90.units import metres, millimetres

FARTHEST = metres(2 ** 31)  # m from the map's origin: ARCL and maps use 32 bits for mm
UNIT_TOLERANCE = 0.01  # largest error of the squared length of a unit quaternion


def is_plausible(pose: Pose) -> bool:
    """Returns whether a robot can have this pose: finite, and in the range of ARCL and maps."""
    place, turn = pose.position, pose.orientation
    norm = turn.x ** 2 + turn.y ** 2 + turn.z ** 2 + turn.w ** 2
    return all(abs(value) <= FARTHEST for value in (place.x, place.y, place.z)) and (
        abs(norm - 1.0) <= UNIT_TOLERANCE)


def pose_from_robot(x_mm: float, y_mm: float, heading_deg: float) -> Pose:
    """Returns a pose in the map frame from the robot's x, y (mm) and heading (degrees)."""
    pose = Pose()
    pose.position.x = metres(x_mm)
    pose.position.y = metres(y_mm)
    pose.orientation = quaternion_from_yaw(math.radians(heading_deg))
    return pose


def pose_to_robot(pose: Pose) -> Tuple[int, int, int]:
    """Returns x, y (mm) and heading (degrees, -180..180) of a pose in `map`, as ARCL uses them."""
    heading = math.degrees(yaw_from_quaternion(pose.orientation))
    return millimetres(pose.position.x), millimetres(pose.position.y), int(round(heading))


def map_to_odom(base_in_map: Pose, base_in_odom: Transform) -> Pose:
    """Returns the pose of the odometry frame in the map, such that the robot's base is at
    `base_in_map`.
    """
    yaw = yaw_from_quaternion(base_in_map.orientation) - yaw_from_quaternion(base_in_odom.rotation)
    odom = Pose()
    odom.orientation = quaternion_from_yaw(yaw)
    x, y = base_in_odom.translation.x, base_in_odom.translation.y
    odom.position.x = base_in_map.position.x - x * math.cos(yaw) + y * math.sin(yaw)
    odom.position.y = base_in_map.position.y - x * math.sin(yaw) - y * math.cos(yaw)
    return odom
