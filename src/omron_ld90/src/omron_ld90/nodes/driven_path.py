"""The driven path of the robot as a nav_msgs/Path; a relocalization of the robot clears it."""
from __future__ import annotations

import math

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

JUMP = 1.5  # m; a robot cannot drive so far between two locations: it was relocalized


class DrivenPath:
    """Keeps the last `length` poses that are at least `step` (m) apart, in `message`."""

    def __init__(self, frame: str, length: int, step: float) -> None:
        self.message = Path()
        self.message.header.frame_id = frame
        self._length = length
        self._step = step

    def add(self, pose: PoseStamped) -> bool:
        """Adds the robot's present pose; returns whether the path has changed."""
        poses = self.message.poses
        if poses:
            last, here = poses[-1].pose.position, pose.pose.position
            moved = math.hypot(here.x - last.x, here.y - last.y)
            if moved < self._step:
                return False
            if moved > JUMP:
                poses = []
        self.message.header.stamp = pose.header.stamp
        self.message.poses = [*poses[-self._length + 1:], pose]
        return True

    def clear(self) -> None:
        """Clears the path."""
        self.message.poses = []
