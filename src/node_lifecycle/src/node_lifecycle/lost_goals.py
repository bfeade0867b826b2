"""Goals of ROS actions that will not end: the server is gone, or a message was lost on its way.

actionlib's client tells of neither. A server publishes its status some five times a second, and a
goal or a result is not on its way for longer than a few of these.
"""
from __future__ import annotations

from enum import Enum
from typing import Any, Optional

from actionlib import ActionClient, ClientGoalHandle, CommState

STATUSES_WAITED = 5  # of the server, in which what is on its way must come


class Loss(Enum):
    """Why a goal will not end."""

    SERVER = 'the server is gone'
    GOAL = 'the server did not hear the goal'
    RESULT = 'the result did not come'


_ON_ITS_WAY = {CommState.WAITING_FOR_GOAL_ACK: Loss.GOAL, CommState.WAITING_FOR_RESULT: Loss.RESULT}


class ServerWatch:
    """The server of one action client. `look` is to be called several times a second."""

    def __init__(self, client: ActionClient) -> None:
        self._client = client
        self._last: Any = None
        self.statuses = 0
        """How many of its statuses `look` has seen."""

    def look(self) -> None:
        """Counts the status that came since the last look."""
        status = self._client.last_status_msg
        if status is not self._last:
            self._last = status
            self.statuses += 1

    @property
    def is_gone(self) -> bool:
        """Does no server publish?"""
        return bool(self._client.status_sub.get_num_connections() == 0)


class GoalWatch:
    """One goal that was sent to a server."""

    def __init__(self, server: ServerWatch, handle: ClientGoalHandle) -> None:
        self.handle = handle
        """actionlib forgets a goal whose handle no program keeps."""
        self._server = server
        self._state: int = CommState.WAITING_FOR_GOAL_ACK
        self._since = server.statuses  # when it came to be in this state

    def loss(self) -> Optional[Loss]:
        """Why it will not end; None: it may."""
        if self._server.is_gone:
            return Loss.SERVER
        state = self.handle.get_comm_state()
        if state != self._state:
            self._state, self._since = state, self._server.statuses
        elif self._server.statuses - self._since > STATUSES_WAITED:
            return _ON_ITS_WAY.get(state)
        return None
