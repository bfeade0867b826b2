"""Goals of ROS actions, for the vehicle's table of actions: any server, any type."""
from __future__ import annotations

import threading
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

import actionlib
import roslib.message
from actionlib import ClientGoalHandle, CommState, GoalStatus

from node_lifecycle import ConfigurationError
from vda5050_vehicle.core.action_table import ActionSpec, ActionTable, Call

OnEnd = Callable[[str, bool, str], None]  # name of the goal, whether it succeeded, what was said


def check_types(table: ActionTable) -> None:
    """Raises ConfigurationError where a type is not installed, or lacks a field of a goal."""
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
                                         f'which a goal of {spec.call.type} has not.')


def _goal_type(call: Call) -> Any:
    return roslib.message.get_message_class(f'{call.type}Goal')


class RosActions:
    """Starts goals and tells how each ends, once; what a server says is cut to one line."""

    def __init__(self, on_end: OnEnd) -> None:
        """`on_end` may be called from any thread."""
        self._on_end = on_end
        self._clients: Dict[Tuple[str, str], actionlib.ActionClient] = {}
        self._open: Dict[str, Tuple[actionlib.ActionClient, Optional[ClientGoalHandle]]] = {}
        self._lock = threading.Lock()

    def prepare(self, table: ActionTable) -> None:
        """Connects to the servers, so that the first goal need not wait."""
        for spec in table.specs.values():
            if spec.call is not None:
                self._client(spec.call)

    def _client(self, call: Call) -> actionlib.ActionClient:
        key = (call.server, call.type)
        if key not in self._clients:
            self._clients[key] = actionlib.ActionClient(
                call.server, roslib.message.get_message_class(f'{call.type}Action'))
        return self._clients[key]

    def start(self, name: str, spec: ActionSpec, arguments: Mapping[str, Any]) -> None:
        """Sends the goal of a line of the table; `name` is the goal's in `on_end`."""
        call = spec.call
        if call is None:
            raise ValueError(f'{spec.action_type} is no goal of a ROS action')
        client = self._client(call)
        if client.pub_goal.get_num_connections() == 0:
            self._on_end(name, False, f'there is no action server {call.server}')
            return
        goal = _goal_type(call)(**call.fields(arguments))
        with self._lock:
            self._open[name] = (client, None)
        handle = client.send_goal(goal, lambda handle: self._on_transition(name, handle))
        with self._lock:
            if name in self._open:
                self._open[name] = (client, handle)  # actionlib forgets what nobody keeps

    def cancel(self, name: str) -> None:
        """Ends a goal; `on_end` tells when it has."""
        with self._lock:
            handle = self._open.get(name, (None, None))[1]
        if handle is not None:
            handle.cancel()

    def check(self) -> None:
        """Ends goals whose server is gone; to be called now and then."""
        with self._lock:
            gone = [(name, client) for name, (client, _) in self._open.items()
                    if client.status_sub.get_num_connections() == 0]
        for name, client in gone:
            self._end(name, False, f'the action server {client.ns} is gone')

    def _on_transition(self, name: str, handle: ClientGoalHandle) -> None:
        if handle.get_comm_state() != CommState.DONE:
            return
        status = handle.get_terminal_state()
        text = handle.get_goal_status_text() or GoalStatus.to_string(status)
        self._end(name, status == GoalStatus.SUCCEEDED, text)

    def _end(self, name: str, succeeded: bool, text: str) -> None:
        with self._lock:
            if self._open.pop(name, None) is None:
                return
        printable = ''.join(char if char.isprintable() else ' ' for char in text)
        self._on_end(name, succeeded, printable[:300])
