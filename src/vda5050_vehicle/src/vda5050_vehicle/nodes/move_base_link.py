"""The pose driver on ROS: goals of the action move_base (move_base_msgs/MoveBase)."""
from __future__ import annotations

import actionlib
import rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

from node_lifecycle.headings import quaternion_from_yaw
from vda5050_vehicle.drivers.pose_driver import GoTo, PoseCommand, PoseDriver
from vda5050_vehicle.nodes.action_goals import ActionGoals
from vda5050_vehicle.nodes.route_link import Tell


class MoveBaseLink:
    """Sends the commands of a driver, and reports to the driver when goals have ended."""

    def __init__(self, driver: PoseDriver, tell: Tell, map_frame: str) -> None:
        self._driver = driver
        self._tell = tell
        self._frame = map_frame
        self._goals = ActionGoals(self._on_end)
        self._client = actionlib.ActionClient('move_base', MoveBaseAction)

    def carry_out(self, command: PoseCommand) -> None:
        """Sends a goal, or cancels all goals, including those of an adapter that was killed."""
        if isinstance(command, GoTo):
            self._goals.send(str(command.number), self._client, self._goal(command))
        else:
            self._goals.cancel_all(self._client)

    def _goal(self, command: GoTo) -> MoveBaseGoal:
        goal = MoveBaseGoal()
        goal.target_pose.header.frame_id = self._frame
        goal.target_pose.header.stamp = rospy.Time.now()
        pose = goal.target_pose.pose
        pose.position.x, pose.position.y = command.x, command.y
        pose.orientation = quaternion_from_yaw(command.theta)
        return goal

    def check(self) -> None:
        """Checks the goals; the caller calls it several times a second."""
        self._goals.check()

    def _on_end(self, name: str, succeeded: bool, text: str) -> None:
        self._tell(lambda now: self._driver.on_goal_ended(int(name), succeeded, text, now))
