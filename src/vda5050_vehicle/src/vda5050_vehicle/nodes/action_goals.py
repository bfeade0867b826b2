"""Goals of ROS actions. Each goal ends exactly once, even if its server is late, absent or lost."""
from __future__ import annotations

import threading
import time
from dataclasses import dataclass, replace
from typing import Any, Callable, Dict, Optional

from actionlib import ActionClient, ClientGoalHandle, CommState, GoalStatus

from node_lifecycle.lost_goals import GoalWatch, Loss, ServerWatch, is_connected

PATIENCE = 5.0  # s that a goal waits for its server, because the server may still be starting
_LOSSES = {
    Loss.SERVER: 'the action server {} has disappeared',
    Loss.GOAL: 'the action server {} did not receive the goal',
    Loss.RESULT: 'the result of the action server {} was lost'}

OnEnd = Callable[[str, bool, str], None]  # name of the goal, whether it succeeded, result text
Clock = Callable[[], float]


@dataclass(frozen=True)
class _Goal:
    """A goal. It waits for its server until the time `until` (s); `sent` is None while it waits."""

    client: ActionClient
    goal: Any
    until: float
    sent: Optional[GoalWatch] = None


class ActionGoals:
    """Goals with names that the caller chooses.

    A message that is published before the server is connected is lost. So goals and cancellations
    are kept until the server is connected. The caller must call `check` several times a second, and
    call `send`, `cancel`, `cancel_all` and `check` in one thread.
    """

    def __init__(self, on_end: OnEnd, clock: Clock = time.monotonic) -> None:
        """`on_end` may be called from any thread."""
        self._on_end = on_end
        self._clock = clock
        self._lock = threading.Lock()
        self._goals: Dict[str, _Goal] = {}
        self._servers: Dict[str, ServerWatch] = {}  # by the name of the action
        self._to_clear: Dict[str, ActionClient] = {}  # servers whose goals must be cancelled

    def send(self, name: str, client: ActionClient, goal: Any) -> None:
        """Sends the goal now, or as soon as its server is connected."""
        with self._lock:
            self._goals[name] = _Goal(client, goal, self._clock() + PATIENCE)
        self.check()

    def cancel(self, name: str) -> None:
        """Cancels a goal; `on_end` is called when it has ended."""
        goal = self._goals.get(name)
        if goal is None:
            return
        if goal.sent is None:
            self._end(name, False, 'the goal was cancelled before its server was connected')
        else:
            goal.sent.handle.cancel()

    def cancel_all(self, client: ActionClient) -> None:
        """Cancels all goals of a server, including those that another client has sent."""
        for name, goal in list(self._goals.items()):
            if goal.client is client and goal.sent is None:
                self.cancel(name)
        self._to_clear[client.ns] = client
        self.check()

    def check(self) -> None:
        """Sends the messages that can be sent now; ends the goals of absent or lost servers."""
        clear = [client for client in self._to_clear.values()
                 if client.pub_cancel.get_num_connections() > 0]
        for client in clear:
            client.cancel_all_goals()
            del self._to_clear[client.ns]
        if clear:
            return  # the cancellation could also cancel a goal that is sent now
        for server in self._servers.values():
            server.count_status()
        for name, goal in list(self._goals.items()):
            if goal.sent is not None:
                loss = goal.sent.loss()
                if loss is not None:
                    self._end(name, False, _LOSSES[loss].format(goal.client.ns))
            elif is_connected(goal.client):
                self._send(name, goal)
            elif self._clock() >= goal.until:
                self._end(name, False, f'there is no action server {goal.client.ns}')

    def _send(self, name: str, goal: _Goal) -> None:
        handle = goal.client.send_goal(goal.goal, lambda handle: self._on_transition(name, handle))
        with self._lock:
            if name in self._goals:  # it may have ended already
                server = self._servers.setdefault(goal.client.ns, ServerWatch(goal.client))
                self._goals[name] = replace(goal, sent=GoalWatch(server, handle))

    def _on_transition(self, name: str, handle: ClientGoalHandle) -> None:
        if handle.get_comm_state() == CommState.DONE:
            status = handle.get_terminal_state()
            text = handle.get_goal_status_text() or GoalStatus.to_string(status)
            self._end(name, status == GoalStatus.SUCCEEDED, text)

    def _end(self, name: str, succeeded: bool, text: str) -> None:
        with self._lock:
            if self._goals.pop(name, None) is None:
                return
        printable = ''.join(char if char.isprintable() else ' ' for char in text)
        self._on_end(name, succeeded, printable[:300])
