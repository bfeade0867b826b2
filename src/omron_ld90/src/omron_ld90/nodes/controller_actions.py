"""The controller's two actions: a command to its completion, and driving to a pose.

Succeeded is SUCCEEDED; cancelled, and replaced by another command, is PREEMPTED; whatever else
ended the command is ABORTED with a text that says what; what was never sent is REJECTED. Commands
may run side by side: queries do, and a driving command replaces the one before it in the robot.

Locks: actionlib calls `_on_goal` and `_on_cancel` with its own lock held, and takes that lock in
every method of a goal handle. So no lock of ours is held while a handle is used, and the robot's
thread uses none: it leaves that to a `CallQueue`.
"""
from __future__ import annotations

import math
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Tuple

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

from omron_arcl import ArclError, Execution, NotConnected, Outcome, Result, printable
from omron_arcl.command_line import is_stop
from omron_arcl.overruling import Overruled
from omron_ld90.nodes.controller_action_server import ActionServer
from omron_ld90.nodes.controller_refusals import Refusals, failure
from omron_ld90.nodes.support.call_queue import CallQueue
from omron_ld90.nodes.support.callers import caller_of
from omron_ld90.nodes.support.old_messages import OldMessages
from omron_ld90.nodes.support.poses import pose_to_robot
from omron_ld90_msgs.msg import (
    ExecuteCommandAction,
    ExecuteCommandFeedback,
    ExecuteCommandGoal,
    ExecuteCommandResult,
)

_QUEUE_PARAMETER = 'actionlib_server_pub_queue_size'  # read by actionlib, for all servers here
_RESULTS_QUEUED = 1000
OWN_CONNECTION = 5.0  # s to wait for the topic of its own goals

# Gives a command of a node; raises ArclError. (text, giver, timeout, on_line, on_end) -> Execution
Execute = Callable[..., Execution]
Cancel = Callable[[Execution, str], None]  # cancels a command for a node

_OUTCOMES: Dict[Outcome, int] = {
    Outcome.SUCCEEDED: ExecuteCommandResult.SUCCEEDED,
    Outcome.REJECTED: ExecuteCommandResult.FAILED,
    Outcome.NO_GOAL: ExecuteCommandResult.FAILED,
    Outcome.UNKNOWN_COMMAND: ExecuteCommandResult.FAILED,
    Outcome.FAILED: ExecuteCommandResult.FAILED,
    Outcome.EMERGENCY_STOPPED: ExecuteCommandResult.EMERGENCY_STOPPED,
    Outcome.INTERRUPTED: ExecuteCommandResult.INTERRUPTED,
    Outcome.CANCELLED: ExecuteCommandResult.CANCELLED,
    Outcome.TIMED_OUT: ExecuteCommandResult.TIMED_OUT,
    Outcome.LOST: ExecuteCommandResult.LOST,
}
_PREEMPTED = (Outcome.INTERRUPTED, Outcome.CANCELLED)


class Refused(Exception):
    """A goal or pose that no command can be made of; the text says why."""


class NeverSent(Refused):
    """A goal that is not carried out because of its moment; the text says why."""


def robot_pose(pose: PoseStamped, map_frame: str) -> Tuple[int, int, int]:
    """x, y (mm), heading (degrees) of a pose in the map frame; raises Refused."""
    frame = pose.header.frame_id.lstrip('/')
    if frame != map_frame:
        raise Refused(f'the pose is in the frame "{frame}", not in "{map_frame}"')
    p, q = pose.pose.position, pose.pose.orientation
    if not all(math.isfinite(number) for number in (p.x, p.y, q.x, q.y, q.z, q.w)):
        raise Refused('the pose holds a number that is not finite')
    if abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) > 0.01:
        raise Refused('the orientation is no unit quaternion')
    if max(abs(p.x), abs(p.y)) > 1e6:
        raise Refused('the position is more than 1000 km away')
    return pose_to_robot(pose.pose)


class _Goal:
    """A goal of an action, and the command that it became."""

    def __init__(self, handle: actionlib.ServerGoalHandle) -> None:
        self.handle = handle
        self.execution: Optional[Execution] = None


class _Actions:
    """Goals of one action server and the commands that they are."""

    def __init__(self, name: str, kind: type, execute: Execute,
                 cancel: Cancel, old: OldMessages) -> None:
        self._topic = f'{name}/goal'
        self._execute = execute
        self._cancel = cancel
        self._old = old
        self._running: Dict[str, _Goal] = {}
        self._lock = threading.Lock()  # guards _running
        self._calls = CallQueue(f'action {name}')
        old.watch(self._topic)
        _keep_results()
        self._server = ActionServer(name, kind, self._on_goal, self._on_cancel, self._is_stop)
        self._server.start()

    # --- from actionlib, which holds its lock ----------------------------------------------------

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        try:
            command, timeout = self._command_of(handle.get_goal())
            reason = self._old.reason(handle.goal, self._topic, is_stop(command))
            if reason:
                raise NeverSent(reason)
            self._start(handle, command, timeout)
        except (ArclError, Refused) as error:
            handle.set_rejected(self._refusal(error), str(error))
            self._tell(handle.get_goal_id().id, str(error))

    def _start(self, handle: actionlib.ServerGoalHandle, text: str, timeout: float) -> None:
        """Gives the command and accepts the goal; raises ArclError, the goal still pending.

        The command may end before the goal is accepted here. Its result is set afterwards all the
        same: actionlib holds its lock until this returns.
        """
        goal_id = handle.get_goal_id().id
        goal = _Goal(handle)
        with self._lock:
            self._running[goal_id] = goal
        try:
            goal.execution = self._execute(
                text, self._giver(handle), timeout=timeout or None, stop_on_timeout=True,
                on_line=lambda line: self._calls.add(lambda: self._on_line(handle, line),
                                                     optional=True),
                on_end=lambda result: self._calls.add(
                    lambda: self._on_end(handle, text, result)))
        except ArclError:
            with self._lock:
                del self._running[goal_id]
            raise
        handle.set_accepted()

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        goal_id = handle.get_goal_id().id
        with self._lock:
            goal = self._running.get(goal_id)
        if goal and goal.execution:
            self._cancel(goal.execution, self._server.canceller)

    # --- in the thread of the calls --------------------------------------------------------------

    def _on_end(self, handle: actionlib.ServerGoalHandle, command: str, result: Result) -> None:
        goal_id = handle.get_goal_id().id
        with self._lock:
            del self._running[goal_id]
        message = self._result(result)
        text = f'{result.outcome.value}: {printable(result.words)}'
        if result.outcome is Outcome.SUCCEEDED:
            handle.set_succeeded(message, text)
        elif result.outcome in _PREEMPTED:
            handle.set_canceled(message, text)
        else:
            handle.set_aborted(message, text)
        self._tell(goal_id, failure(command, result))

    def _handles(self) -> List[actionlib.ServerGoalHandle]:
        """Of the goals whose commands are under way."""
        with self._lock:
            return [goal.handle for goal in self._running.values()]

    # --- what a kind of action is ----------------------------------------------------------------

    def _giver(self, handle: actionlib.ServerGoalHandle) -> str:
        """The node that gave a goal."""
        return caller_of(handle.goal)

    def _command_of(self, goal: Any) -> Tuple[str, float]:
        """The command that a goal means, and its time-out (0: its own); raises Refused."""
        raise NotImplementedError

    def _is_stop(self, goal: Any) -> bool:
        """Whether a goal stops the robot."""
        return False

    def _on_line(self, handle: actionlib.ServerGoalHandle, line: str) -> None:
        """A line that belongs to the command; by default told nobody."""

    def _result(self, result: Result) -> object:
        raise NotImplementedError

    def _refusal(self, reason: Exception) -> object:
        """The result of a goal that is not taken."""
        raise NotImplementedError

    def _tell(self, goal_id: str, reason: Optional[str]) -> None:
        """The goal has ended; `reason` where it came to nothing. By default told nobody else."""


def _keep_results() -> None:
    """More results may wait for a client than actionlib's 50: one that is dropped never comes."""
    if not rospy.has_param(_QUEUE_PARAMETER):
        rospy.set_param(_QUEUE_PARAMETER, _RESULTS_QUEUED)


class ExecuteCommandServer(_Actions):
    """Action `execute_command`."""

    def __init__(self, execute: Execute, cancel: Cancel, old: OldMessages) -> None:
        super().__init__('execute_command', ExecuteCommandAction, execute, cancel, old)

    def _is_stop(self, goal: ExecuteCommandGoal) -> bool:
        return is_stop(goal.command)

    def _command_of(self, goal: ExecuteCommandGoal) -> Tuple[str, float]:
        if not (math.isfinite(goal.timeout) and goal.timeout >= 0.0):
            raise Refused(f'the timeout is {goal.timeout}, but must be 0 or more seconds')
        return goal.command, goal.timeout

    def _on_line(self, handle: actionlib.ServerGoalHandle, line: str) -> None:
        handle.publish_feedback(ExecuteCommandFeedback(line=line))

    def _result(self, result: Result) -> ExecuteCommandResult:
        left_out = f' ({result.left_out} more lines were left out)' if result.left_out else ''
        return ExecuteCommandResult(outcome=_OUTCOMES[result.outcome],
                                    message=printable(result.words, 1000) + left_out,
                                    lines=list(result.lines))

    def _refusal(self, reason: Exception) -> ExecuteCommandResult:
        """LOST, and never sent, where the command as such was well: it may be given again.

        INTERRUPTED where somebody else's word came first.
        """
        if isinstance(reason, Overruled):
            return ExecuteCommandResult(outcome=ExecuteCommandResult.INTERRUPTED,
                                        message=str(reason))
        if isinstance(reason, (NotConnected, NeverSent)):
            return ExecuteCommandResult(outcome=ExecuteCommandResult.LOST,
                                        message=f'never sent: {reason}')
        return ExecuteCommandResult(outcome=ExecuteCommandResult.REFUSED, message=str(reason))


class MoveBaseServer(_Actions):
    """Action `move_base`; feedback is where the robot is, whenever it says so.

    A goal that comes by topic becomes a goal of the action, as with the real move_base: whoever
    watches `move_base/status` sees a new one.
    """

    def __init__(self, execute: Execute, cancel: Cancel, old: OldMessages, refusals: Refusals,
                 map_frame: str) -> None:
        self._map_frame = map_frame
        self._refusals = refusals
        self._forwarded: Dict[str, str] = {}  # goal id -> who gave it by topic
        self._count = 0
        super().__init__('move_base', MoveBaseAction, execute, cancel, old)
        self._goals = rospy.Publisher(self._topic, MoveBaseActionGoal, queue_size=10)
        self._await_own_connection()

    def _await_own_connection(self) -> None:
        """Until goals published here arrive here, or else the first one might be lost."""
        deadline = time.monotonic() + OWN_CONNECTION
        while not self._goals.get_num_connections() and time.monotonic() < deadline:
            time.sleep(0.01)

    def feedback(self, pose: PoseStamped) -> None:
        """The robot is at `pose`."""
        for handle in self._handles():
            self._calls.add(partial(handle.publish_feedback,
                                    MoveBaseFeedback(base_position=pose)), optional=True)

    def forward(self, pose: PoseStamped, caller: str) -> None:
        """Makes a goal of the action of a pose that `caller` gave by topic."""
        goal = MoveBaseActionGoal()
        goal.header.stamp = goal.goal_id.stamp = rospy.Time.now()
        with self._lock:
            self._count += 1
            goal.goal_id.id = (f'{rospy.get_name()}-simple-{self._count}-'
                               f'{goal.goal_id.stamp.to_sec():.9f}')
            self._forwarded[goal.goal_id.id] = caller
        goal.goal.target_pose = pose
        self._goals.publish(goal)

    def _giver(self, handle: actionlib.ServerGoalHandle) -> str:
        with self._lock:
            return self._forwarded.get(handle.get_goal_id().id, '') or super()._giver(handle)

    def _command_of(self, goal: MoveBaseGoal) -> Tuple[str, float]:
        return 'gotoPoint {} {} {}'.format(*robot_pose(goal.target_pose, self._map_frame)), 0.0

    def _result(self, result: Result) -> MoveBaseResult:
        return MoveBaseResult()

    def _refusal(self, reason: Exception) -> MoveBaseResult:
        return MoveBaseResult()

    def _tell(self, goal_id: str, reason: Optional[str]) -> None:
        """Who gave a goal by topic has no result to look at."""
        with self._lock:
            caller = self._forwarded.pop(goal_id, None)
        if caller and reason:
            self._refusals.tell('gotoPoint', caller, reason)
