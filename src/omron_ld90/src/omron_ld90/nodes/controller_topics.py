"""The controller's incoming topics: commands, and the poses of two RViz tools."""
from __future__ import annotations

from typing import Callable, Optional

import rospy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from std_msgs.msg import String

from omron_arcl import ArclError, Execution, Giver, Result
from omron_arcl.command_line import is_stop
from omron_ld90.nodes.controller_actions import GoalRefused, Obeyed
from omron_ld90.nodes.controller_move_base import MoveBaseServer, robot_pose
from omron_ld90.nodes.controller_refusals import Refusals, failure
from omron_ld90.nodes.support.callers import giver_of
from omron_ld90.nodes.support.old_messages import OldMessages


class TopicCommands:
    """Subscribes to the topics.

    execute       -- gives a command; raises ArclError
    obeyed        -- returns the drive that a command would only repeat, or None
    refuse_click  -- returns why a click must not move the robot now, or None if it may; the
                     messages of 2D Nav Goal and 2D Pose Estimate are clicks
    """

    def __init__(self, execute: Callable[..., Execution], obeyed: Obeyed,
                 move_base: MoveBaseServer,
                 refusals: Refusals, old: OldMessages, map_frame: str,
                 refuse_click: Callable[[], Optional[str]]) -> None:
        self._execute = execute
        self._obeyed = obeyed
        self._refuse_click = refuse_click
        self._move_base = move_base
        self._refusals = refusals
        self._map_frame = map_frame
        self._old = old
        for topic, kind, queue_size, callback in (
                ('send_command', String, 100, self._on_command),
                ('move_base_simple/goal', PoseStamped, 1, self._on_goal_pose),
                ('initialpose', PoseWithCovarianceStamped, 1, self._on_initial_pose)):
            old.watch(topic)
            rospy.Subscriber(topic, kind, self._unless_refused(callback, topic),
                             queue_size=queue_size, tcp_nodelay=True)

    def _unless_refused(self, callback: Callable[[rospy.Message, Giver], None],
                        topic: str) -> Callable[[rospy.Message], None]:
        def receive(message: rospy.Message) -> None:
            giver = giver_of(message)
            is_click = not isinstance(message, String)
            text = topic if is_click else message.data
            reason = self._old.reason(message, topic, is_stop(text))
            if is_click and not reason:
                reason = self._refuse_click()
            if reason:
                self._refusals.refused(text, giver.name, reason)
            else:
                callback(message, giver)
        return receive

    def _on_command(self, message: String, giver: Giver) -> None:
        self._send(message.data, giver)

    def _on_goal_pose(self, message: PoseStamped, giver: Giver) -> None:
        """Turns the pose into a goal of the action `move_base`, so that observers of the action see
        it.
        """
        try:
            robot_pose(message, self._map_frame)
        except GoalRefused as error:
            self._refusals.refused('gotoPoint', giver.name, f'The goal was not sent: {error}.')
        else:
            self._move_base.forward(message, giver)

    def _on_initial_pose(self, message: PoseWithCovarianceStamped, giver: Giver) -> None:
        pose = PoseStamped(header=message.header, pose=message.pose.pose)
        try:
            x, y, heading = robot_pose(pose, self._map_frame)
        except GoalRefused as error:
            self._refusals.refused('localizeToPoint', giver.name,
                                f'The pose was not sent: {error}.')
        else:
            self._send(f'localizeToPoint {x} {y} {heading}', giver)

    def _send(self, text: str, giver: Giver) -> None:
        """Sends a command, and reports its failure, because no caller waits for the result."""
        if self._obeyed(text, giver):
            return
        def on_end(result: Result) -> None:
            reason = failure(text, result)
            if reason:
                self._refusals.refused(text, giver.name, reason)

        try:
            self._execute(text, giver, on_end=on_end)
        except ArclError as error:
            self._refusals.refused(text, giver.name, str(error))
