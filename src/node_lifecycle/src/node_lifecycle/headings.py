"""Headings in the plane (rad) in the form of ROS: as quaternions about z (REP 103)."""
from __future__ import annotations

import math

from geometry_msgs.msg import Quaternion


def quaternion_from_yaw(yaw: float) -> Quaternion:
    """Returns the rotation about z."""
    return Quaternion(0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))


def yaw_from_quaternion(q: Quaternion) -> float:
    """Returns the yaw in [-pi, pi] of any rotation, with any roll and pitch."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
