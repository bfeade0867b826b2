"""The action `move_base`: drives to a pose, with the interface of the navigation stack."""
from __future__ import annotations

import math
import time
from functools import partial
from typing import Callable, Dict, Optional, Tuple

import actionlib
import rospy
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import (
    MoveBaseAction,
    MoveBaseActionGoal,
    MoveBaseFeedback,
    MoveBaseGoal,
    MoveBaseResult,
)

from omron_arcl import Giver, Result
from omron_ld90.nodes.controller_actions import Cancel, CommandActions, Execute, GoalRefused, Obeyed
from omron_ld90.nodes.controller_refusals import Refusals
from omron_ld90.nodes.support.old_messages import OldMessages
from omron_ld90.nodes.support.poses import pose_to_robot

OWN_CONNECTION = 5.0  # s, maximum wait until the node is connected to its own goal topic


def robot_pose(pose: PoseStamped, map_frame: str) -> Tuple[int, int, int]:
    """Returns x, y (mm), heading (degrees) of a pose in the map frame; raises GoalRefused."""
    frame = pose.header.frame_id.lstrip('/')
    if frame != map_frame:
        raise GoalRefused(f'the pose is in the frame "{frame}", not in "{map_frame}"')
    p, q = pose.pose.position, pose.pose.orientation
    if not all(math.isfinite(number) for number in (p.x, p.y, q.x, q.y, q.z, q.w)):
        raise GoalRefused('the pose contains a number that is not finite')
    if abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) > 0.01:
        raise GoalRefused('the orientation is no unit quaternion')
    if max(abs(p.x), abs(p.y)) > 1e6:
        raise GoalRefused('the position is more than 1000 km away')
    return pose_to_robot(pose.pose)


class MoveBaseServer(CommandActions):
    """The action `move_base`. Each reported pose of the robot is its feedback.

    As with the original move_base, a pose that comes by a topic becomes a goal of the action. So a
    program that watches `move_base/status` sees this goal.
    """

    def __init__(self, execute: Execute, cancel: Cancel, cancel_all: Callable[[Giver], None],
                 obeyed: Obeyed, old: OldMessages, refusals: Refusals, map_frame: str) -> None:
        self._map_frame = map_frame
        self._refusals = refusals
        self._forwarded: Dict[str, Giver] = {}  # goal id -> giver, for goals that came by a topic
        self._count = 0
        super().__init__('move_base', MoveBaseAction, execute, cancel, cancel_all, obeyed, old)
        self._goals = rospy.Publisher(self._topic, MoveBaseActionGoal, queue_size=10)
        self._await_own_connection()

    def _await_own_connection(self) -> None:
        """Waits until this node can receive its own goals, so that the first goal is not lost."""
        deadline = time.monotonic() + OWN_CONNECTION
        while not self._goals.get_num_connections() and time.monotonic() < deadline:
            time.sleep(0.01)

    def feedback(self, pose: PoseStamped) -> None:
        """Publishes the robot's `pose` as feedback."""
        for handle in self._handles():
            self._calls.add(partial(handle.publish_feedback,
                                    MoveBaseFeedback(base_position=pose)), optional=True)

    def forward(self, pose: PoseStamped, giver: Giver) -> None:
        """Sends the pose that `giver` published on a topic to the action, as a goal."""
        goal = MoveBaseActionGoal()
        goal.header.stamp = goal.goal_id.stamp = rospy.Time.now()
        with self._lock:
            self._count += 1
            goal.goal_id.id = (f'{rospy.get_name()}-simple-{self._count}-'
                               f'{goal.goal_id.stamp.to_sec():.9f}')
            self._forwarded[goal.goal_id.id] = giver
        goal.goal.target_pose = pose
        self._goals.publish(goal)

    def _giver(self, handle: actionlib.ServerGoalHandle) -> Giver:
        goal_id = handle.get_goal_id().id
        with self._lock:
            forwarded_for = self._forwarded.get(goal_id)
        return forwarded_for or super()._giver(handle)

    def _command_of(self, goal: MoveBaseGoal) -> Tuple[str, float]:
        return 'gotoPoint {} {} {}'.format(*robot_pose(goal.target_pose, self._map_frame)), 0.0

    def _result(self, result: Result) -> MoveBaseResult:
        return MoveBaseResult()

    def _refusal(self, reason: Exception) -> MoveBaseResult:
        return MoveBaseResult()

    def _goal_ended(self, goal_id: str, reason: Optional[str]) -> None:
        """Reports the failure of a goal that came by a topic, because its giver gets no result."""
        with self._lock:
            giver = self._forwarded.pop(goal_id, None)
        if giver and reason:
            self._refusals.refused('gotoPoint', giver.name, reason)
