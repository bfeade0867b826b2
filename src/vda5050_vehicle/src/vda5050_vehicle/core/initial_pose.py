"""Decides whether the robot has taken the pose of initPosition. Metres, radians, seconds."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from vda5050_vehicle.drivers.robot_view import RobotPose, RobotSnapshot

WITHIN = (0.5, 0.3)  # m, rad: the largest error of the pose after the robot has localized itself
SAME = (0.1, 0.1)    # m, rad: up to this difference, a pose equals the requested pose
PATIENCE = 10.0      # s within which the robot must take the pose


@dataclass(frozen=True)
class PoseWish:
    """A pose that was sent to the robot; `within` (m, rad) is the permitted error."""

    action_id: str
    pose: RobotPose
    last_node: str
    within: Tuple[float, float]
    until: float

    @staticmethod
    def told(action_id: str, pose: RobotPose, last_node: str, before: Optional[RobotPose],
             now: float) -> PoseWish:
        """Returns the wish for a pose that is sent to the robot now.

        before -- the robot's pose until now. The robot must cover at least half of the distance
                  from this pose to the requested pose.
        """
        within = WITHIN
        if before is not None:
            metres, radians = (min(most, max(same, apart / 2.0)) for most, same, apart
                               in zip(WITHIN, SAME, _apart(before, pose)))
            within = metres, radians
        return PoseWish(action_id, pose, last_node, within, now + PATIENCE)

    def is_taken(self, robot: RobotSnapshot) -> bool:
        """Returns whether the robot has taken the pose."""
        return robot.pose is not None and robot.localized and all(
            apart <= within for apart, within in zip(_apart(robot.pose, self.pose), self.within))


def _apart(pose: RobotPose, other: RobotPose) -> Tuple[float, float]:
    turn = math.remainder(pose.theta - other.theta, 2.0 * math.pi)
    return math.dist((pose.x, pose.y), (other.x, other.y)), abs(turn)
