"""Makes missions from clicks that concern a robot of a fleet manager."""
from __future__ import annotations

from typing import Callable, Dict, Optional

import rospy

from fleet_requests import MissionNews, NotSent, Sender, mission_request, stored_status
from itrci_nav_msgs.msg import MissionRequest, MissionStatus
from omron_ld90.operator.goal_clicks import Target
from omron_ld90.operator.notices import NoticeSeverity, OperatorNotice

_ENDINGS = {
    MissionStatus.SUCCEEDED: (NoticeSeverity.GOOD, 'has succeeded'),
    MissionStatus.FAILED: (NoticeSeverity.BAD, 'has failed'),
    MissionStatus.REFUSED: (NoticeSeverity.BAD, 'was refused'),
    MissionStatus.CANCELLED: (NoticeSeverity.INFO, 'was cancelled'),
    MissionStatus.EXPIRED: (NoticeSeverity.BAD, 'has expired')}

Tell = Callable[[OperatorNotice, Optional[Target]], None]


class FleetMissions:
    """Sends missions to a robot, and reports how they end.

    robot -- the robot's name in the fleet, which is the name of its namespace
    tell  -- called with the end of a mission, and the target of the mission
    """

    def __init__(self, robot: str, tell: Tell) -> None:
        self._robot = robot
        self._tell = tell
        self._sent: Dict[int, Target] = {}
        self._news = MissionNews()
        self._requests = Sender(MissionRequest)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=100)

    def send(self, target: Target) -> OperatorNotice:
        """Sends the robot to the vertex that `target` names; returns a message about it."""
        request = mission_request([int(target.name)], robot=self._robot)
        self._news.heard(request.request_id)
        self._sent[request.request_id] = target
        try:
            self._requests.send(request)
        except NotSent as reason:
            del self._sent[request.request_id]
            self._news.ended(request.request_id)
            return OperatorNotice(NoticeSeverity.BAD, f'Not sent. {reason}')
        return OperatorNotice(NoticeSeverity.INFO,
                              f'{self._robot} to vertex {target.name}, as mission '
                              f'{request.request_id} ...')

    def ask(self) -> None:
        """Queries the state of missions without news, because this node may have missed their end.
        This call may block.
        """
        for id in self._news.silent():
            if id not in self._sent:
                continue
            answer = stored_status(id)
            if answer is None:
                continue
            if answer.found:
                self._on_status(answer.status)
            else:
                self._end(id, OperatorNotice(NoticeSeverity.BAD,
                                             f'Mission {id} has not reached the fleet '
                                             'manager: click again'))

    def _on_status(self, message: MissionStatus) -> None:
        id, ending = message.request_id, _ENDINGS.get(message.state)
        if id not in self._sent:
            return
        if ending is None:
            self._news.heard(id)
            return
        severity, words = ending
        reason = f': {message.reason}' if message.reason else ''
        self._end(id, OperatorNotice(severity, f'Mission {id} {words}{reason}'))

    def _end(self, id: int, notice: OperatorNotice) -> None:
        target = self._sent.pop(id, None)
        self._news.ended(id)
        if target is not None:
            self._tell(notice, target)
