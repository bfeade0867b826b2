"""The common base of the controller's actions: each goal becomes one command for the robot.

The states of a goal at its end:
- SUCCEEDED: the command succeeded.
- PREEMPTED: the command was cancelled, or replaced by another command.
- ABORTED: the command ended in another way; the text says how.
- REJECTED: the command was never sent.
If a giver repeats the command that the robot obeys already, the new goal takes over the drive: the
robot is not interrupted, and the earlier goal becomes PREEMPTED.
Several queries may be under way at the same time. A driving command replaces the driving command
before it in the robot.

Locks: actionlib calls `_on_goal` and `_on_cancel` while it holds its own lock, and takes this lock
in every method of a goal handle. So this module holds no lock of its own while it uses a handle.
The robot's thread uses no handle: a `CallQueue` calls the handles instead.
"""
from __future__ import annotations

import threading
from typing import Any, Callable, Dict, List, Optional, Tuple

import actionlib
import rospy

from omron_arcl import ArclError, Execution, Giver, Outcome, Result, printable
from omron_arcl.command_line import is_stop
from omron_ld90.nodes.controller_action_server import ActionServer
from omron_ld90.nodes.controller_refusals import failure
from omron_ld90.nodes.support.call_queue import CallQueue
from omron_ld90.nodes.support.callers import giver_of
from omron_ld90.nodes.support.old_messages import OldMessages

_QUEUE_PARAMETER = 'actionlib_server_pub_queue_size'  # actionlib reads it for this namespace
_RESULTS_QUEUED = 1000

# Gives a command; raises ArclError. Arguments: text, giver, known_epoch, number, ...
Execute = Callable[..., Execution]
# Returns the drive that a command would only repeat, or None. Arguments: text, giver, known_epoch
Obeyed = Callable[..., Optional[Execution]]
Cancel = Callable[[Execution, Giver], None]  # cancels a command for a giver

_PREEMPTED = (Outcome.INTERRUPTED, Outcome.CANCELLED)


class GoalRefused(Exception):
    """A goal or pose cannot become a command; the text says why."""


class NeverSent(GoalRefused):
    """A goal was not carried out because it was too old; the text says why."""


class _Goal:
    """A goal of an action, and the command that it became."""

    def __init__(self, handle: actionlib.ServerGoalHandle, id: str) -> None:
        self.handle, self.id = handle, id
        self.execution: Optional[Execution] = None


class CommandActions:
    """The goals of one action server, and their commands."""

    def __init__(self, name: str, kind: type, execute: Execute, cancel: Cancel,
                 cancel_all: Callable[[Giver], None], obeyed: Obeyed, old: OldMessages) -> None:
        self._topic = f'{name}/goal'
        self._execute = execute
        self._cancel = cancel
        self._obeyed = obeyed
        self._old = old
        self._running: Dict[str, _Goal] = {}
        self._lock = threading.Lock()  # guards _running
        self._calls = CallQueue(f'action {name}')
        old.watch(self._topic)
        _keep_results()
        self._server = ActionServer(name, kind, self._on_goal, self._on_cancel, self._is_stop,
                                    lambda: cancel_all(self._server.canceller))
        self._server.start()

    # --- called by actionlib, which holds its lock -----------------------------------------------

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        try:
            command, timeout = self._command_of(handle.get_goal())
            reason = self._old.reason(handle.goal, self._topic, is_stop(command))
            if reason:
                raise NeverSent(reason)
            self._start(handle, command, timeout)
        except (ArclError, GoalRefused) as error:
            handle.set_rejected(self._refusal(error), str(error))
            self._goal_ended(handle.get_goal_id().id, str(error))

    def _start(self, handle: actionlib.ServerGoalHandle, text: str, timeout: float) -> None:
        """Gives the command, and accepts the goal. Raises ArclError; then the goal stays pending.

        The command may end before the goal is accepted here. Its result is still set afterwards,
        because actionlib holds its lock until this method returns.
        """
        goal_id, giver = handle.get_goal_id().id, self._giver(handle)
        known_epoch = self._known_epoch(handle.get_goal())
        if self._adopt_drive(handle, self._obeyed(text, giver, known_epoch)):
            return
        goal = _Goal(handle, goal_id)
        with self._lock:
            self._running[goal_id] = goal
        try:
            goal.execution = self._execute(
                text, giver, known_epoch=known_epoch, timeout=timeout or None,
                number=self._number(handle.get_goal()),
                stop_on_timeout=True,
                on_line=lambda line: self._calls.add(lambda: self._on_line(goal.handle, line),
                                                     optional=True),
                on_end=lambda result: self._calls.add(lambda: self._on_end(goal, text, result)))
        except ArclError:
            with self._lock:
                del self._running[goal_id]
            raise
        handle.set_accepted()

    def _adopt_drive(self, handle: actionlib.ServerGoalHandle, drive: Optional[Execution]) -> bool:
        """Gives a goal the `drive` of an earlier goal. Returns False if there is no such goal."""
        goal_id = handle.get_goal_id().id
        with self._lock:
            earlier = next((id for id, goal in self._running.items()
                            if drive is not None and goal.execution is drive), None)
            if earlier is None or goal_id in self._running:
                return False
            goal = self._running[goal_id] = self._running.pop(earlier)
            before, goal.handle, goal.id = goal.handle, handle, goal_id
        handle.set_accepted()
        before.set_canceled(None, 'the same goal was given again')
        self._goal_ended(earlier, None)
        return True

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        goal_id = handle.get_goal_id().id
        with self._lock:
            goal = self._running.get(goal_id)
        if goal and goal.execution:
            self._cancel(goal.execution, self._server.canceller)

    # --- called by the thread of the call queue --------------------------------------------------

    def _on_end(self, goal: _Goal, command: str, result: Result) -> None:
        with self._lock:
            handle, goal_id = goal.handle, goal.id
            del self._running[goal_id]
        message = self._result(result)
        text = f'{result.outcome.value}: {printable(result.words)}'
        if result.outcome is Outcome.SUCCEEDED:
            handle.set_succeeded(message, text)
        elif result.outcome in _PREEMPTED:
            handle.set_canceled(message, text)
        else:
            handle.set_aborted(message, text)
        self._goal_ended(goal_id, failure(command, result))

    def _handles(self) -> List[actionlib.ServerGoalHandle]:
        """Returns the handles of the goals whose commands are under way."""
        with self._lock:
            return [goal.handle for goal in self._running.values()]

    # --- defined by each kind of action ----------------------------------------------------------

    def _giver(self, handle: actionlib.ServerGoalHandle) -> Giver:
        """Returns the program that gave a goal."""
        return giver_of(handle.goal)

    def _known_epoch(self, goal: Any) -> int:
        """Returns the epoch in which a goal is valid; 0: any epoch."""
        return 0

    def _number(self, goal: Any) -> int:
        """Returns the number that the giver gave to the command; 0: no number."""
        return 0

    def _command_of(self, goal: Any) -> Tuple[str, float]:
        """Returns the command of a goal and its timeout (s). Raises GoalRefused.

        A timeout of 0 means the timeout of the kind of command.
        """
        raise NotImplementedError

    def _is_stop(self, goal: Any) -> bool:
        """Returns whether a goal stops the robot."""
        return False

    def _on_line(self, handle: actionlib.ServerGoalHandle, line: str) -> None:
        """Takes a line that belongs to the command. By default the line is ignored."""

    def _result(self, result: Result) -> object:
        raise NotImplementedError

    def _refusal(self, reason: Exception) -> object:
        """Returns the result of a goal that is refused."""
        raise NotImplementedError

    def _goal_ended(self, goal_id: str, reason: Optional[str]) -> None:
        """Takes the end of a goal. By default, nothing is done.

        reason -- why the goal failed; None: it did not fail
        """


def _keep_results() -> None:
    """Lets more results wait for a client than the 50 of actionlib, unless a parameter is set."""
    if not rospy.has_param(_QUEUE_PARAMETER):
        rospy.set_param(_QUEUE_PARAMETER, _RESULTS_QUEUED)
