"""Drives a device at an output and an input of an LD-90, through the robot's omron_controller.

An action goal is never cancelled, because a cancellation would stop the robot.
"""
from __future__ import annotations

import threading
from typing import Any, Optional

from actionlib import ActionClient, CommState

from fleet_core.work.devices import RobotAddress
from fleet_devices.core.device import Reading
from fleet_devices.drivers.driver import Silent
from node_lifecycle.lost_goals import is_connected
from omron_arcl import parse_line, replies
from omron_ld90_msgs.msg import ExecuteCommandAction, ExecuteCommandGoal, ExecuteCommandResult

ANSWER = 2.0  # s within which a command must end


class RobotSignals:
    """The driver of a device that an LD-90 switches. Only one thread calls `exchange`."""

    def __init__(self, address: RobotAddress) -> None:
        self._address = address
        self._client = ActionClient(f'/{address.robot}/execute_command', ExecuteCommandAction)

    def exchange(self, output: Optional[bool]) -> Reading:
        """Sets the output, and reads the output and the input. Raises Silent."""
        address = self._address
        if output is not None:
            self._command(f'output{"On" if output else "Off"} {address.output}')
        return Reading(
            is_on(self._command(f'outputQuery {address.output}').lines, address.output, True),
            is_on(self._command(f'inputQuery {address.input}').lines, address.input, False))

    def _command(self, text: str) -> ExecuteCommandResult:
        if not is_connected(self._client):
            raise Silent(f'the omron_controller of {self._address.robot} does not run')
        ended = threading.Event()

        def on_transition(handle: Any) -> None:
            if handle.get_comm_state() == CommState.DONE:
                ended.set()
        handle = self._client.send_goal(ExecuteCommandGoal(command=text), on_transition)
        if not ended.wait(ANSWER):
            raise Silent(f'{self._address.robot} does not answer {text}')
        result = handle.get_result()
        if result is None or result.outcome != ExecuteCommandResult.SUCCEEDED:
            why = 'no result' if result is None else result.message
            raise Silent(f'{self._address.robot} refuses {text}: {why}'[:200])
        return result


def is_on(lines: Any, name: str, output: bool) -> bool:
    """Returns whether the robot's answer says that an output or input is on.

    output -- whether it is an output
    Raises Silent, also for the third state, `broken`.
    """
    for line in lines:
        reply = parse_line(line)
        if isinstance(reply, replies.Input) and (reply.name, reply.output) == (name, output):
            if reply.state in ('on', 'off'):
                return reply.state == 'on'
            raise Silent(f'the robot says that {name} is {reply.state[:40]}')
    raise Silent(f'the robot does not say whether {name} is on')
