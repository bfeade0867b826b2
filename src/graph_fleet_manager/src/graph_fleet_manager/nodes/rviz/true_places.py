"""The poses that the robots themselves publish, on /<robot>/pose."""
from __future__ import annotations

import math
import time
from typing import Dict, Iterable, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped

from graph_fleet_manager.nodes.rviz.robot_picture import DrawnPose
from node_lifecycle.headings import yaw_from_quaternion

FRESH = 1.5  # s after which a received pose is too old


class TruePlaces:
    """Subscribes to the poses of the given robots, and keeps the last pose of each robot."""

    def __init__(self) -> None:
        self._subscribers: Dict[str, rospy.Subscriber] = {}
        self._heard: Dict[str, Tuple[float, DrawnPose]] = {}

    def follow(self, names: Iterable[str]) -> None:
        """Subscribes to the poses of these robots and no others."""
        names = set(names)
        for name in set(self._subscribers) - names:
            self._subscribers.pop(name).unregister()
            self._heard.pop(name, None)
        for name in names - set(self._subscribers):
            self._subscribers[name] = rospy.Subscriber(
                f'/{name}/pose', PoseStamped, self._on_pose, name, queue_size=1)

    def of(self, name: str) -> Optional[DrawnPose]:
        """Returns the robot's pose; None if no pose came within FRESH."""
        at, place = self._heard.get(name, (-math.inf, None))
        return place if time.monotonic() - at <= FRESH else None

    def last(self, name: str) -> Optional[DrawnPose]:
        """Returns the robot's last pose, of any age; None if none came."""
        return self._heard[name][1] if name in self._heard else None

    def _on_pose(self, message: PoseStamped, name: str) -> None:
        position, turn = message.pose.position, message.pose.orientation
        if math.isfinite(position.x) and math.isfinite(position.y):
            self._heard[name] = time.monotonic(), DrawnPose(
                position.x, position.y, yaw_from_quaternion(turn))
