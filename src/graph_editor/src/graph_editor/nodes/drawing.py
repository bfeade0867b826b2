"""Markers in the map frame, flat on the floor. Metres, radians."""
from __future__ import annotations

import math
from typing import Iterable, Sequence, Tuple

from geometry_msgs.msg import Point, Pose
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

MAP_FRAME = 'map'


def colour(red: float, green: float, blue: float, alpha: float = 1.0) -> ColorRGBA:
    """Parts of 0..1."""
    return ColorRGBA(red, green, blue, alpha)


def pose_at(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Pose:
    """A place and a direction."""
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = x, y, z
    pose.orientation.z, pose.orientation.w = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    return pose


def disc(diameter: float, z: float, paint: ColorRGBA) -> Marker:
    """A flat disc around the origin."""
    marker = Marker(type=Marker.CYLINDER, color=paint, pose=pose_at(0.0, 0.0, z))
    marker.scale.x, marker.scale.y, marker.scale.z = diameter, diameter, 0.01
    return marker


def strip(points: Iterable[Sequence[float]], width: float, z: float, paint: ColorRGBA) -> Marker:
    """A line through points (N,2)."""
    marker = Marker(type=Marker.LINE_STRIP, color=paint, pose=pose_at(0.0, 0.0))
    marker.scale.x = width
    marker.points = [Point(float(x), float(y), z) for x, y in points]
    return marker


def arrow(yaw: float, length: float, width: float, z: float, paint: ColorRGBA,
          at: Tuple[float, float] = (0.0, 0.0)) -> Marker:
    """A flat triangle whose tip is `length` ahead of a place."""
    ahead = math.cos(yaw), math.sin(yaw)
    aside = -ahead[1] * width / 2.0, ahead[0] * width / 2.0
    marker = Marker(type=Marker.TRIANGLE_LIST, color=paint, pose=pose_at(*at))
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    corners = ((length * ahead[0], length * ahead[1]), aside, (-aside[0], -aside[1]))
    marker.points = [Point(x, y, z) for x, y in corners]
    return marker


def text(words: str, x: float, y: float, z: float, height: float, paint: ColorRGBA) -> Marker:
    """Words that face the viewer, in the middle of a place."""
    marker = Marker(type=Marker.TEXT_VIEW_FACING, text=words, color=paint, pose=pose_at(x, y, z))
    marker.scale.z = height
    return marker
