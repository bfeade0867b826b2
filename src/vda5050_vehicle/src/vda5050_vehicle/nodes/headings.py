"""Headings in the plane as ROS has them: quaternions about z (REP 103), rad."""
from __future__ import annotations

import math

from geometry_msgs.msg import Quaternion


def quaternion(heading: float) -> Quaternion:
    """The rotation to a heading."""
    return Quaternion(0.0, 0.0, math.sin(heading / 2.0), math.cos(heading / 2.0))


def heading(q: Quaternion) -> float:
    """The heading of a rotation, whatever its roll and pitch."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
