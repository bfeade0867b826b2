"""Executes the vehicle's table of actions as goals of ROS actions: any server, any type."""
from __future__ import annotations

from typing import Any, Dict, Mapping, Tuple

import actionlib
import roslib.message

from node_lifecycle import ConfigurationError
from node_lifecycle.lost_goals import is_connected
from vda5050_vehicle.core.action_table import ActionCall, ActionSpec, ActionTable
from vda5050_vehicle.nodes.action_goals import ActionGoals, OnEnd


def check_types(table: ActionTable) -> None:
    """Raises ConfigurationError if a type is not installed or does not have a field of a goal."""
    for spec in table.specs.values():
        if spec.call is None:
            continue
        goal = _goal_type(spec.call)
        if goal is None:
            raise ConfigurationError(f'action {spec.action_type} of the table has type '
                                     f'{spec.call.type}, which is not installed.')
        for name in spec.call.goal:
            if name not in goal.__slots__:
                raise ConfigurationError(f'action {spec.action_type} of the table sets {name}, '
                                         f'but a goal of {spec.call.type} has no such field.')


def _goal_type(call: ActionCall) -> Any:
    return roslib.message.get_message_class(f'{call.type}Goal')


class RosActions:
    """Starts goals and reports the end of each goal once; result texts are one line."""

    def __init__(self, on_end: OnEnd) -> None:
        """`on_end` may be called from any thread."""
        self._goals = ActionGoals(on_end)
        self._clients: Dict[Tuple[str, str], actionlib.ActionClient] = {}

    def prepare(self, table: ActionTable) -> None:
        """Connects to the servers, so that the first goal does not wait."""
        for spec in table.specs.values():
            if spec.call is not None:
                self._client(spec.call)

    def _client(self, call: ActionCall) -> actionlib.ActionClient:
        key = (call.server, call.type)
        if key not in self._clients:
            self._clients[key] = actionlib.ActionClient(
                call.server, roslib.message.get_message_class(f'{call.type}Action'))
        return self._clients[key]

    def is_ready(self, spec: ActionSpec) -> bool:
        """Returns whether a goal of this action would reach its server now."""
        return spec.call is not None and is_connected(self._client(spec.call))

    def start(self, name: str, spec: ActionSpec, arguments: Mapping[str, Any]) -> None:
        """Sends the goal of an action of the table; `on_end` receives the same `name`."""
        call = spec.call
        if call is None:
            raise ValueError(f'{spec.action_type} is not a goal of a ROS action')
        self._goals.send(name, self._client(call), _goal_type(call)(**call.fields(arguments)))

    def cancel(self, name: str) -> None:
        """Cancels a goal; `on_end` is called when it has ended."""
        self._goals.cancel(name)

    def check(self) -> None:
        """Checks the goals; the caller calls it several times a second."""
        self._goals.check()
