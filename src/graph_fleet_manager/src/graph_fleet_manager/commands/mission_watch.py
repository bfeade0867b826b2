"""How a mission goes on until its end, though statuses are lost on the way to a program.

A status is lost where the fleet manager dies before it has sent it, or where a queue overflows. So
the watch asks for it: at first, when the fleet manager has been restarted, and when it has heard
nothing for a while.
"""
from __future__ import annotations

import time
from typing import Callable, FrozenSet, List, Optional, Protocol

import rospy

from graph_fleet_manager.messages.missions import is_about
from itrci_nav_msgs.msg import MissionRequest, MissionStatus
from itrci_nav_msgs.srv import GetMissionStatus

SILENCE = 10.0  # s without news after which the watch asks again

Ask = Callable[[], Optional[MissionStatus]]
"""What is stored of the mission; None: the fleet manager does not answer, or knows nothing."""


class Statuses(Protocol):
    """The messages of /mission_status as they come."""

    def take(self) -> List[MissionStatus]:
        """What came since the last time."""

    def wait(self, seconds: float) -> None:
        """Until something is there, or the time is over."""

    def publishers(self) -> FrozenSet[int]:
        """One number for each connection to a publisher; a new connection has a new one."""


class MissionWatch:
    """The newest status of one mission.

    ask -- asks the fleet manager
    """

    def __init__(self, request: MissionRequest, status: MissionStatus, statuses: Statuses,
                 ask: Ask, clock: Callable[[], float] = time.monotonic) -> None:
        self.status = status
        self._request, self._statuses, self._ask, self._clock = request, statuses, ask, clock
        self._publishers: Optional[FrozenSet[int]] = None
        self._heard = clock()

    def wait(self, seconds: float) -> MissionStatus:
        """The newest status, after a change or after this time."""
        self._statuses.wait(seconds)
        told = [s for s in self._statuses.take() if is_about(s, self._request)]
        publishers = self._statuses.publishers()
        if told:
            self.status, self._heard = told[-1], self._clock()
        if publishers != self._publishers or self._clock() - self._heard > SILENCE:
            stored = self._ask() if publishers else None
            if stored is not None:  # what comes on the topic from now on is newer
                self.status, self._heard, self._publishers = stored, self._clock(), publishers
        return self.status


def ask_for(request: MissionRequest) -> Ask:
    """Asks the service of the fleet manager for this mission."""
    service = rospy.ServiceProxy('/get_mission_status', GetMissionStatus)

    def ask() -> Optional[MissionStatus]:
        try:
            answer = service(request.request_id, request.header.stamp)
        except rospy.ServiceException:  # it is being restarted: the watch asks again
            return None
        return answer.status if answer.found else None
    return ask
