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
from typing import Callable, Dict, List, Optional, Tuple

import actionlib
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseFeedback, MoveBaseResult

from omron_arcl import ArclError, Execution, NotConnected, Outcome, Result
from omron_ld90.nodes.support.call_queue import CallQueue
from omron_ld90.nodes.support.poses import pose_to_robot
from omron_ld90_msgs.msg import (
    ExecuteCommandAction,
    ExecuteCommandFeedback,
    ExecuteCommandResult,
)

# Gives a command; raises ArclError. (text, timeout, on_line, on_end) -> Execution
Execute = Callable[..., Execution]

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
                 cancel: Callable[[Execution], None]) -> None:
        self._execute = execute
        self._cancel = cancel
        self._running: Dict[str, _Goal] = {}
        self._lock = threading.Lock()  # guards _running
        self._calls = CallQueue(f'action {name}')
        self._server = actionlib.ActionServer(name, kind, self._on_goal, self._on_cancel,
                                              auto_start=False)
        self._server.start()

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
                text, timeout=timeout or None, stop_on_timeout=True,
                on_line=lambda line: self._calls.add(lambda: self._on_line(handle, line),
                                                     optional=True),
                on_end=lambda result: self._calls.add(lambda: self._on_end(handle, result)))
        except ArclError:
            with self._lock:
                del self._running[goal_id]
            raise
        handle.set_accepted()

    def _on_end(self, handle: actionlib.ServerGoalHandle, result: Result) -> None:
        goal_id = handle.get_goal_id().id
        with self._lock:
            del self._running[goal_id]
        message = self._result(result)
        text = f'{result.outcome.value}: {result.words}'
        if result.outcome is Outcome.SUCCEEDED:
            handle.set_succeeded(message, text)
        elif result.outcome in _PREEMPTED:
            handle.set_canceled(message, text)
        else:
            handle.set_aborted(message, text)

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        goal_id = handle.get_goal_id().id
        with self._lock:
            goal = self._running.get(goal_id)
        if goal:
            self._cancel(goal.execution)

    def _handles(self) -> List[actionlib.ServerGoalHandle]:
        """Of the goals whose commands are under way."""
        with self._lock:
            return [goal.handle for goal in self._running.values()]

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        raise NotImplementedError

    def _on_line(self, handle: actionlib.ServerGoalHandle, line: str) -> None:
        raise NotImplementedError

    def _result(self, result: Result) -> object:
        raise NotImplementedError


class ExecuteCommandServer(_Actions):
    """Action `execute_command`."""

    def __init__(self, execute: Execute, cancel: Callable[[Execution], None]) -> None:
        super().__init__('execute_command', ExecuteCommandAction, execute, cancel)

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        goal = handle.get_goal()
        try:
            if not (math.isfinite(goal.timeout) and goal.timeout >= 0.0):
                raise Refused(f'the timeout is {goal.timeout}, but must be 0 or more seconds')
            self._start(handle, goal.command, goal.timeout)
        except NotConnected as error:
            message = f'never sent: {error.reason}'
            handle.set_rejected(
                ExecuteCommandResult(outcome=ExecuteCommandResult.LOST, message=message), message)
        except (ArclError, Refused) as error:
            handle.set_rejected(
                ExecuteCommandResult(outcome=ExecuteCommandResult.REFUSED, message=str(error)),
                str(error))

    def _on_line(self, handle: actionlib.ServerGoalHandle, line: str) -> None:
        handle.publish_feedback(ExecuteCommandFeedback(line=line))

    def _result(self, result: Result) -> ExecuteCommandResult:
        return ExecuteCommandResult(outcome=_OUTCOMES[result.outcome], message=result.words,
                                    lines=list(result.lines))


class MoveBaseServer(_Actions):
    """Action `move_base`; feedback is where the robot is, whenever it says so."""

    def __init__(self, execute: Execute, cancel: Callable[[Execution], None],
                 map_frame: str) -> None:
        self._map_frame = map_frame
        super().__init__('move_base', MoveBaseAction, execute, cancel)

    def feedback(self, pose: PoseStamped) -> None:
        """The robot is at `pose`."""
        for handle in self._handles():
            self._calls.add(lambda handle=handle: handle.publish_feedback(
                MoveBaseFeedback(base_position=pose)), optional=True)

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        try:
            target = robot_pose(handle.get_goal().target_pose, self._map_frame)
            self._start(handle, 'gotoPoint {} {} {}'.format(*target), 0.0)
        except (ArclError, Refused) as error:
            handle.set_rejected(MoveBaseResult(), str(error))

    def _on_line(self, handle: actionlib.ServerGoalHandle, line: str) -> None:
        """The robot's lines tell nothing that move_base's feedback could hold."""

    def _result(self, result: Result) -> MoveBaseResult:
        return MoveBaseResult()
