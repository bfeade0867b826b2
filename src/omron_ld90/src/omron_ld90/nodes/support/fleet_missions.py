"""Clicks on a robot that a fleet manager manages become missions."""
from __future__ import annotations

import random
from typing import Callable, Dict, Optional

import rospy

from itrci_nav_msgs.msg import MissionRequest, MissionStatus
from omron_ld90.operator.goal_clicks import Target
from omron_ld90.operator.notices import Notice, Severity

_ENDINGS = {
    MissionStatus.SUCCEEDED: (Severity.GOOD, 'has succeeded'),
    MissionStatus.FAILED: (Severity.BAD, 'has failed'),
    MissionStatus.REFUSED: (Severity.BAD, 'was refused'),
    MissionStatus.CANCELLED: (Severity.INFO, 'was cancelled')}

Tell = Callable[[Notice, Optional[Target]], None]


class FleetMissions:
    """Sends missions to a robot, and hears what becomes of them.

    robot -- its name in the fleet: that of its namespace
    tell  -- is called with what became of a mission, and the target that it was for
    """

    def __init__(self, robot: str, tell: Tell) -> None:
        self._robot = robot
        self._tell = tell
        self._sent: Dict[int, Target] = {}
        self._requests = rospy.Publisher('/mission_request', MissionRequest, queue_size=10)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=100)

    def send(self, target: Target) -> Notice:
        """Sends the robot to the vertex that `target` is named after; tells that, or why not."""
        if not self._requests.get_num_connections():
            return Notice(Severity.BAD, 'Not sent: nobody takes missions. Is path_supervisor '
                                        'running?')
        request = MissionRequest(request_id=random.randint(1, 2 ** 31 - 1), robot=self._robot,
                                 destination_vertices_id=[int(target.name)])
        request.header.stamp = rospy.Time.now()
        self._sent[request.request_id] = target
        self._requests.publish(request)
        return Notice(Severity.INFO, f'{self._robot} to vertex {target.name}, as mission '
                                     f'{request.request_id} ...')

    def _on_status(self, message: MissionStatus) -> None:
        target = self._sent.get(message.request_id)
        ending = _ENDINGS.get(message.state)
        if target is None or ending is None:
            return
        del self._sent[message.request_id]
        severity, words = ending
        reason = f': {message.reason}' if message.reason else ''
        self._tell(Notice(severity, f'Mission {message.request_id} {words}{reason}'), target)
