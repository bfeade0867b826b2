"""The topic /fleet_poses: the poses of all robots, for displays that subscribe to only one topic.
"""
from __future__ import annotations

import math
from typing import Dict, Iterable

import genpy
import rospy

from itrci_nav_msgs.msg import ExecutionRouteStates, FleetPose, FleetPoses
from node_lifecycle.periodic import Periodic

PERIOD = 0.2  # s between two messages
FRAME = 'map'


class FleetPosesTopic:
    """Keeps the last pose of each robot, and publishes them all while there is a subscriber.

    It does not use the deciding thread. So a display does not slow the fleet manager down.
    """

    def __init__(self, robots: Iterable[str]) -> None:
        self._poses: Dict[str, FleetPose] = {
            robot: FleetPose(robot, math.nan, math.nan, math.nan, genpy.Time(0))
            for robot in robots}
        self._publisher = rospy.Publisher('/fleet_poses', FleetPoses, queue_size=1)
        Periodic('fleet poses', PERIOD, self._tick)

    def note(self, robot: str, report: ExecutionRouteStates) -> None:
        """Keeps the pose in a robot's report. A report without a pose changes nothing."""
        if math.isfinite(report.x) and math.isfinite(report.y):
            self._poses[robot] = FleetPose(robot, report.x, report.y, report.theta,
                                           report.header.stamp)

    def message(self, now: genpy.Time) -> FleetPoses:
        """Returns the message with the last poses; `now` is its stamp."""
        message = FleetPoses(poses=list(self._poses.values()))
        message.header.stamp, message.header.frame_id = now, FRAME
        return message

    def _tick(self) -> None:
        if self._publisher.get_num_connections():
            self._publisher.publish(self.message(rospy.Time.now()))
