"""When the robot has taken the pose that initPosition told it. Metres, radians, seconds."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from vda5050_vehicle.drivers.robot_view import Pose, RobotView

WITHIN = (0.5, 0.3)  # m, rad: as far off a robot may be that has matched its surroundings
SAME = (0.1, 0.1)    # m, rad: the pose told
PATIENCE = 10.0      # s until the robot must have taken it


@dataclass(frozen=True)
class PoseWish:
    """A pose that the robot was told; `within` (m, rad) of it, the robot has taken it."""

    action_id: str
    pose: Pose
    last_node: str
    within: Tuple[float, float]
    until: float

    @staticmethod
    def told(action_id: str, pose: Pose, last_node: str, before: Optional[Pose],
             now: float) -> PoseWish:
        """The robot is told now; `before` is its pose until then.

        A pose has become the one told where it has lost half its distance to it, at least.
        """
        within = WITHIN
        if before is not None:
            metres, radians = (min(most, max(same, apart / 2.0)) for most, same, apart
                               in zip(WITHIN, SAME, _apart(before, pose)))
            within = metres, radians
        return PoseWish(action_id, pose, last_node, within, now + PATIENCE)

    def is_taken(self, robot: RobotView) -> bool:
        """Whether the robot is where it was told to be."""
        return robot.pose is not None and robot.localized and all(
            apart <= within for apart, within in zip(_apart(robot.pose, self.pose), self.within))


def _apart(pose: Pose, other: Pose) -> Tuple[float, float]:
    turn = math.remainder(pose.theta - other.theta, 2.0 * math.pi)
    return math.dist((pose.x, pose.y), (other.x, other.y)), abs(turn)
