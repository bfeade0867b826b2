"""Clicks on a robot that a fleet manager manages: they become missions, or are refused."""
from __future__ import annotations

import random
import time
from typing import Callable, Dict, Optional

import rospy

from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionRequest, MissionStatus
from omron_ld90.operator.goal_clicks import Target
from omron_ld90.operator.notices import Notice, Severity

SILENCE = 3.0  # s without /fleet_state after which nobody manages the robot any more
WITH_A_PERSON = frozenset((FleetRobot.TAKEN_OVER, FleetRobot.FAILED, FleetRobot.OFF_GRAPH,
                           FleetRobot.OUT_OF_SERVICE))
"""States in which the fleet manager waits for a person to bring the robot back."""
_ENDINGS = {
    MissionStatus.SUCCEEDED: (Severity.GOOD, 'has succeeded'),
    MissionStatus.FAILED: (Severity.BAD, 'has failed'),
    MissionStatus.REFUSED: (Severity.BAD, 'was refused'),
    MissionStatus.CANCELLED: (Severity.INFO, 'was cancelled')}

Tell = Callable[[Notice, Optional[Target]], None]


class FleetMissions:
    """Knows by /fleet_state whether the robot is managed, and sends it missions.

    robot -- its name in the fleet: that of its namespace
    tell  -- is called with what became of a mission, and the target that it was for
    """

    def __init__(self, robot: str, tell: Tell) -> None:
        self._robot = robot
        self._tell = tell
        self._heard: Optional[float] = None
        self._sent: Dict[int, Target] = {}
        self._requests = rospy.Publisher('/mission_request', MissionRequest, queue_size=10)
        rospy.Subscriber('/fleet_state', FleetState, self._on_fleet, queue_size=1)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=100)

    @property
    def manages(self) -> bool:
        """Does a fleet manager manage the robot, and has not left it to a person?"""
        return self._heard is not None and time.monotonic() - self._heard <= SILENCE

    def send(self, target: Optional[Target]) -> Notice:
        """Sends the robot to a vertex; tells that, or why not and what to do instead."""
        command = f'rosrun graph_fleet_manager mission VERTEX --robot {self._robot}'
        if target is None or not target.name.isdigit():
            return Notice(Severity.BAD, f'Not sent: the fleet manager drives {self._robot}. Use '
                                        f'"{command}", or "fleet out {self._robot}" first.')
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

    def _on_fleet(self, message: FleetState) -> None:
        own = next((robot for robot in message.robots if robot.name == self._robot), None)
        is_managed = own is not None and own.state not in WITH_A_PERSON
        self._heard = time.monotonic() if is_managed else None

    def _on_status(self, message: MissionStatus) -> None:
        target = self._sent.get(message.request_id)
        ending = _ENDINGS.get(message.state)
        if target is None or ending is None:
            return
        del self._sent[message.request_id]
        severity, words = ending
        reason = f': {message.reason}' if message.reason else ''
        self._tell(Notice(severity, f'Mission {message.request_id} {words}{reason}'), target)
