"""Where the robot drove, as a nav_msgs/Path; it begins anew where the robot was relocalised."""
from __future__ import annotations

import math

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

JUMP = 1.5  # m between two locations: further than the robot drives; it was relocalised


class DrivenPath:
    """The last `length` poses that are at least `step` (m) apart; `message` is what they make."""

    def __init__(self, frame: str, length: int, step: float) -> None:
        self.message = Path()
        self.message.header.frame_id = frame
        self._length = length
        self._step = step

    def add(self, pose: PoseStamped) -> bool:
        """The robot is here now; whether the path has changed."""
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
        """Forgets where the robot drove."""
        self.message.poses = []
