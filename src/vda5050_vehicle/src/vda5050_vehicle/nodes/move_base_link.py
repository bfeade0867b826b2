"""The pose driver on ROS: goals of the action move_base (move_base_msgs/MoveBase)."""
from __future__ import annotations

import threading
from typing import Dict

import actionlib
import rospy
from actionlib import ClientGoalHandle, CommState, GoalStatus
from actionlib_msgs.msg import GoalID
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

from vda5050_vehicle.drivers.pose_driver import GoTo, PoseCommand, PoseDriver
from vda5050_vehicle.nodes.headings import quaternion
from vda5050_vehicle.nodes.route_link import Tell


class MoveBaseLink:
    """Carries the driver's commands, and tells it how goals end."""

    def __init__(self, driver: PoseDriver, tell: Tell, map_frame: str) -> None:
        self._driver = driver
        self._tell = tell
        self._frame = map_frame
        self._lock = threading.Lock()
        self._open: Dict[int, ClientGoalHandle] = {}
        self._client = actionlib.ActionClient('move_base', MoveBaseAction)

    def carry_out(self, command: PoseCommand) -> None:
        """Sends a goal, or cancels them all: also those of an adapter that was killed."""
        if not isinstance(command, GoTo):
            self._client.cancel_all_goals()
            if self._client.pub_cancel.get_num_connections() == 0:
                self._client.pub_cancel.publish(GoalID())
            return
        if self._client.pub_goal.get_num_connections() == 0:
            self._end(command.number, False, 'there is no action server move_base')
            return
        goal = MoveBaseGoal()
        goal.target_pose.header.frame_id = self._frame
        goal.target_pose.header.stamp = rospy.Time.now()
        pose = goal.target_pose.pose
        pose.position.x, pose.position.y = command.x, command.y
        pose.orientation = quaternion(command.theta)
        handle = self._client.send_goal(
            goal, lambda handle: self._on_transition(command.number, handle))
        with self._lock:
            self._open = {command.number: handle}  # those before it are replaced by it

    def check(self) -> None:
        """Ends the goal whose server is gone; to be called now and then."""
        if self._client.status_sub.get_num_connections() == 0:
            with self._lock:
                numbers = list(self._open)
                self._open.clear()
            for number in numbers:
                self._end(number, False, 'move_base is gone')

    def _on_transition(self, number: int, handle: ClientGoalHandle) -> None:
        if handle.get_comm_state() == CommState.DONE:
            status = handle.get_terminal_state()
            text = handle.get_goal_status_text() or GoalStatus.to_string(status)
            self._end(number, status == GoalStatus.SUCCEEDED, text)

    def _end(self, number: int, succeeded: bool, text: str) -> None:
        self._tell(lambda now: self._driver.on_goal_ended(number, succeeded, text))
