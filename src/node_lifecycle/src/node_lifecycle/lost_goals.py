"""Detects goals of ROS actions that will not end: the server is gone, or a message was lost.

actionlib's client reports neither case. A server publishes its status about five times a second,
and a goal or a result arrives within a few of these periods.
"""
from __future__ import annotations

from enum import Enum
from typing import Any, Optional

from actionlib import ActionClient, ClientGoalHandle, CommState

STATUSES_WAITED = 5  # a goal or a result must arrive before the server has sent more statuses


class Loss(Enum):
    """Why a goal will not end."""

    SERVER = 'the server is gone'
    GOAL = 'the server did not receive the goal'
    RESULT = 'the result did not arrive'


_ON_ITS_WAY = {CommState.WAITING_FOR_GOAL_ACK: Loss.GOAL, CommState.WAITING_FOR_RESULT: Loss.RESULT}


class ServerWatch:
    """Watches an action client's server. A caller must call `count_status` several times a second.
    """

    def __init__(self, client: ActionClient) -> None:
        self._client = client
        self._last: Any = None
        self.statuses = 0
        """The number of statuses that `count_status` has counted."""

    def count_status(self) -> None:
        """Counts a status if one has come since the last call."""
        status = self._client.last_status_msg
        if status is not self._last:
            self._last = status
            self.statuses += 1

    @property
    def is_gone(self) -> bool:
        """Whether no server publishes."""
        return bool(self._client.status_sub.get_num_connections() == 0)


class GoalWatch:
    """One goal that was sent to a server."""

    def __init__(self, server: ServerWatch, handle: ClientGoalHandle) -> None:
        self.handle = handle
        """The handle; it is kept because actionlib forgets a goal without a handle."""
        self._server = server
        self._state: int = CommState.WAITING_FOR_GOAL_ACK
        self._since = server.statuses  # number of statuses when this state began

    def loss(self) -> Optional[Loss]:
        """Returns why the goal will not end; None if it may still end."""
        if self._server.is_gone:
            return Loss.SERVER
        state = self.handle.get_comm_state()
        if state != self._state:
            self._state, self._since = state, self._server.statuses
        elif self._server.statuses - self._since > STATUSES_WAITED:
            return _ON_ITS_WAY.get(state)
        return None


def is_connected(client: ActionClient) -> bool:
    """Returns whether all topics of the client are connected, so that no message is lost."""
    return all(end.get_num_connections() > 0 for end in (
        client.pub_goal, client.pub_cancel, client.status_sub, client.feedback_sub,
        client.result_sub))
