"""Follows a mission until its end, even if statuses are lost on the way to the program.

A status is lost if the fleet manager ends before it has sent the status, or if a queue overflows.
So the watch asks the fleet manager for the stored status: at the beginning, after a restart of the
fleet manager, and after some time without a status.

State: the newest status, its time of arrival, and the connections at that time. Events: a status
arrives, a connection begins or ends, time passes without a status. Invariants: a stored status
replaces only a status that came earlier; after each restart of the fleet manager the watch asks.
"""
from __future__ import annotations

import time
from typing import Callable, FrozenSet, Optional, Protocol

from fleet_requests import SILENCE, stored_status
from graph_fleet_manager.commands.fleet_client import MessageSource
from graph_fleet_manager.messages.missions import is_about
from itrci_nav_msgs.msg import MissionRequest, MissionStatus

Ask = Callable[[], Optional[MissionStatus]]
"""Returns the stored status; None: the fleet manager does not answer, or has no such mission."""


class Statuses(MessageSource, Protocol):
    """A source of the messages of /mission_status."""

    def publishers(self) -> FrozenSet[int]:
        """Returns one number for each connection to a publisher. Each new connection gets a new
        number.
        """


class MissionWatch:
    """Keeps the newest status of one mission.

    ask -- asks the fleet manager for the stored status
    """

    def __init__(self, request: MissionRequest, status: MissionStatus, statuses: Statuses,
                 ask: Ask, clock: Callable[[], float] = time.monotonic) -> None:
        self.status = status
        self._request, self._statuses, self._ask, self._clock = request, statuses, ask, clock
        self._publishers: Optional[FrozenSet[int]] = None
        self._heard = clock()

    def wait(self, seconds: float) -> MissionStatus:
        """Waits at most this time (s) for a message, and returns the newest status."""
        self._statuses.wait(seconds)
        told = [s for s in self._statuses.unread() if is_about(s, self._request)]
        publishers = self._statuses.publishers()
        if told:
            self.status, self._heard = told[-1], self._clock()
        if publishers != self._publishers or self._clock() - self._heard > SILENCE:
            stored = self._ask() if publishers else None
            if stored is not None:  # messages that come from now on are newer
                self.status, self._heard, self._publishers = stored, self._clock(), publishers
        return self.status


def ask_for(request: MissionRequest) -> Ask:
    """Returns a function that asks the fleet manager's service for this mission."""
    def ask() -> Optional[MissionStatus]:
        answer = stored_status(request.request_id, request.header.stamp)
        return None if answer is None or not answer.found else answer.status
    return ask
