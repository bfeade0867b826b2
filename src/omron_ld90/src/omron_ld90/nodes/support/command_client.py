"""Gives commands to the controller with its action `execute_command`, and reports how they end.

actionlib calls back while it holds its own lock. This module calls back from a separate thread, so
that callbacks may take locks and give commands.
"""
from __future__ import annotations

import threading
from typing import Callable, Dict, Optional

import actionlib
from actionlib import ClientGoalHandle, CommState

from node_lifecycle.lost_goals import GoalWatch, Loss, ServerWatch
from omron_ld90.nodes.support.call_queue import CallQueue
from omron_ld90_msgs.msg import (
    ExecuteCommandAction,
    ExecuteCommandFeedback,
    ExecuteCommandGoal,
    ExecuteCommandResult,
)

_LOSSES = {
    Loss.SERVER: 'omron_controller is gone',
    Loss.GOAL: 'omron_controller did not receive the command',
    Loss.RESULT: 'the result of omron_controller did not arrive'}

OnEnd = Callable[[int, ExecuteCommandResult], None]
OnLine = Callable[[int, str], None]


class CommandClient:
    """Gives commands, and reports each end exactly once; LOST if the controller has gone."""

    def __init__(self, on_end: OnEnd, on_line: Optional[OnLine] = None,
                 numbers_grow: bool = False) -> None:
        """on_end -- called with the number of a command and its end

        on_line -- called with the number of a command and a line of the robot about it
        numbers_grow -- numbers always grow, also after a restart, so the controller may use them
        """
        self._numbers_grow = numbers_grow
        self._on_end = on_end
        self._on_line = on_line
        self._lock = threading.Lock()  # guards _open; not held during callbacks
        self._open: Dict[int, Optional[GoalWatch]] = {}  # None: the command is being sent
        self._callbacks = CallQueue('execute_command')
        self._client = actionlib.ActionClient('execute_command', ExecuteCommandAction)
        self._server = ServerWatch(self._client)

    @property
    def controller_is_there(self) -> bool:
        """Whether a command would reach the controller, and its result would come back."""
        client = self._client
        return all(end.get_num_connections() > 0
                   for end in (client.pub_goal, client.status_sub, client.result_sub))

    def give(self, number: int, command: str, known_epoch: int = 0) -> None:
        """Gives an ARCL command.

        number -- identifies the command in the callbacks; each number is used once
        known_epoch -- the epoch in which the command is valid; 0 (for a person's command): any
        """
        with self._lock:
            self._open[number] = None
        if not self.controller_is_there:
            self._end_later(number, ExecuteCommandResult(
                outcome=ExecuteCommandResult.NEVER_SENT,
                message='omron_controller is not running'))
            return
        handle = self._client.send_goal(
            ExecuteCommandGoal(command=command, number=number if self._numbers_grow else 0,
                               known_epoch=known_epoch),
            transition_cb=lambda handle: self._on_transition(number, handle),
            feedback_cb=lambda handle, feedback: self._on_feedback(number, feedback))
        with self._lock:
            if number in self._open:  # it may have ended already
                self._open[number] = GoalWatch(self._server, handle)

    def check(self) -> None:
        """Ends commands that the controller will not end; to be called several times a second.

        If the controller has gone, these are all commands. Otherwise they are commands whose goal
        or result was lost; the goal may be lost if the controller has just started.
        """
        self._server.count_status()
        with self._lock:
            opened = list(self._open.items())
        for number, goal in opened:
            loss = goal.loss() if goal is not None else None
            if loss is not None:
                self._end_later(number, _lost(_LOSSES[loss]))

    def close(self) -> None:
        """Ends the thread of the callbacks."""
        self._callbacks.close()

    def _on_transition(self, number: int, handle: ClientGoalHandle) -> None:
        if handle.get_comm_state() == CommState.DONE:
            self._end_later(number, result_of(handle))

    def _on_feedback(self, number: int, feedback: ExecuteCommandFeedback) -> None:
        on_line = self._on_line
        if on_line:
            self._callbacks.add(lambda: on_line(number, feedback.line), optional=True)

    def _end_later(self, number: int, result: ExecuteCommandResult) -> None:
        self._callbacks.add(lambda: self._end(number, result))

    def _end(self, number: int, result: ExecuteCommandResult) -> None:
        with self._lock:
            if number not in self._open:
                return
            del self._open[number]
        self._on_end(number, result)


def result_of(handle: ClientGoalHandle) -> ExecuteCommandResult:
    """Returns the result of a command whose goal is done.

    If a goal was cancelled before it arrived, actionlib itself ends the goal, with an empty result.
    """
    result = handle.get_result()
    text = handle.get_goal_status_text()
    if result is None:
        return _lost(f'omron_controller lost the command: {text}')
    if result.outcome == ExecuteCommandResult.NONE:
        return ExecuteCommandResult(outcome=ExecuteCommandResult.CANCELLED,
                                    message=text or 'it was cancelled before')
    return result


def _lost(message: str) -> ExecuteCommandResult:
    return ExecuteCommandResult(outcome=ExecuteCommandResult.LOST, message=message)
