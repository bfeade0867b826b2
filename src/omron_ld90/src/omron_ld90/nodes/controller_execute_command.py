"""The action `execute_command`: carries out a command, and reports its end in the robot's words."""
from __future__ import annotations

import math
from typing import Callable, Dict, Tuple

import actionlib

from omron_arcl import Busy, Giver, NotConnected, Outcome, Result, printable
from omron_arcl.command_line import is_stop
from omron_arcl.drives import Overruled, Unclear
from omron_ld90.nodes.controller_actions import (
    Cancel,
    CommandActions,
    Execute,
    GoalRefused,
    NeverSent,
    Obeyed,
)
from omron_ld90.nodes.support.old_messages import OldMessages
from omron_ld90_msgs.msg import (
    ExecuteCommandAction,
    ExecuteCommandFeedback,
    ExecuteCommandGoal,
    ExecuteCommandResult,
)

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
    Outcome.NEVER_SENT: ExecuteCommandResult.NEVER_SENT,
    Outcome.OVERRULED: ExecuteCommandResult.OVERRULED,
}


class ExecuteCommandServer(CommandActions):
    """Action `execute_command`."""

    def __init__(self, execute: Execute, cancel: Cancel, cancel_all: Callable[[Giver], None],
                 obeyed: Obeyed, old: OldMessages) -> None:
        super().__init__('execute_command', ExecuteCommandAction, execute, cancel, cancel_all,
                         obeyed, old)

    def _known_epoch(self, goal: ExecuteCommandGoal) -> int:
        return int(goal.known_epoch)

    def _number(self, goal: ExecuteCommandGoal) -> int:
        return int(goal.number)

    def _is_stop(self, goal: ExecuteCommandGoal) -> bool:
        return is_stop(goal.command)

    def _command_of(self, goal: ExecuteCommandGoal) -> Tuple[str, float]:
        if not (math.isfinite(goal.timeout) and goal.timeout >= 0.0):
            raise GoalRefused(f'the timeout is {goal.timeout}, but must be 0 or more seconds')
        return goal.command, goal.timeout

    def _on_line(self, handle: actionlib.ServerGoalHandle, line: str) -> None:
        handle.publish_feedback(ExecuteCommandFeedback(line=line))

    def _result(self, result: Result) -> ExecuteCommandResult:
        left_out = f' ({result.left_out} more lines were omitted)' if result.left_out else ''
        return ExecuteCommandResult(outcome=_OUTCOMES[result.outcome],
                                    message=printable(result.words, 1000) + left_out,
                                    lines=list(result.lines))

    def _refusal(self, reason: Exception) -> ExecuteCommandResult:
        """Returns the result of a refused goal.

        OVERRULED: the command of another giver came first. NEVER_SENT: the command is valid and may
        be given again. REFUSED: otherwise.
        """
        if isinstance(reason, Overruled):
            outcome = ExecuteCommandResult.OVERRULED
        elif isinstance(reason, (Busy, NotConnected, NeverSent, Unclear)):
            outcome = ExecuteCommandResult.NEVER_SENT
        else:
            outcome = ExecuteCommandResult.REFUSED
        return ExecuteCommandResult(outcome=outcome, message=str(reason))
