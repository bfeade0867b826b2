"""The one border between the robot's units (mm, degrees) and those of ROS (m, rad; REP 103)."""
from __future__ import annotations

import math
from typing import Tuple

from geometry_msgs.msg import Pose, Quaternion

MM_PER_M = 1000.0


def metres(millimetres: float) -> float:
    """Length in metres."""
    return millimetres / MM_PER_M


def millimetres(length: float) -> int:
    """Length in metres as the whole millimetres that ARCL and `.map` files hold."""
    return int(round(length * MM_PER_M))


def quaternion_from_yaw(yaw: float) -> Quaternion:
    """Rotation about z by `yaw` radians."""
    return Quaternion(0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))


def yaw_from_quaternion(q: Quaternion) -> float:
    """Yaw in radians, in (-pi, pi], of any rotation."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def pose_from_robot(x_mm: float, y_mm: float, heading_deg: float) -> Pose:
    """A pose in the map frame from the robot's x, y (mm) and heading (degrees)."""
    pose = Pose()
    pose.position.x = metres(x_mm)
    pose.position.y = metres(y_mm)
    pose.orientation = quaternion_from_yaw(math.radians(heading_deg))
    return pose


def pose_to_robot(pose: Pose) -> Tuple[int, int, int]:
    """x, y (mm) and heading (degrees, -180..180) as ARCL takes them, of a pose in `map`."""
    heading = math.degrees(yaw_from_quaternion(pose.orientation))
    return millimetres(pose.position.x), millimetres(pose.position.y), int(round(heading))
