"""Keeps a number of missions open: sends a new mission for each mission that ends.

Each robot on a ring has one long mission of many rounds.
"""
from __future__ import annotations

import threading
from random import Random
from typing import Dict, Mapping, Sequence

import rospy

from itrci_nav_msgs.msg import MissionRequest, MissionStatus
from system_support import connected_publisher

STEP, STOPS = 5, 60  # of a mission on a ring: vertices from stop to stop, number of stops
_OVER = frozenset((MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED,
                   MissionStatus.CANCELLED))


class EndlessMissions:
    """Missions, each to two random vertices. `rings` has the vertices of the rings, by robot name.
    """

    def __init__(self, vertices: Sequence[int], rings: Mapping[str, Sequence[int]]) -> None:
        self._rings = rings
        self._vertices, self._random, self._last = vertices, Random(1), 0
        self._lock = threading.Lock()
        self.open: Dict[int, int] = {}
        """The state of each open mission, by request id."""
        self.ended = dict.fromkeys(_OVER, 0)
        self.reasons: Dict[str, int] = {}
        rospy.Subscriber('/mission_status', MissionStatus, self._hear)
        self._requests = connected_publisher('/mission_request', MissionRequest,
                                             to='path_supervisor')

    def send_round(self) -> None:
        """Sends one mission for each robot on a ring."""
        for robot, ring in self._rings.items():
            stops = [ring[STEP * k % len(ring)] for k in range(1, STOPS + 1)]
            self._publish(MissionRequest(destination_vertices_id=stops, robot=robot, priority=1))

    def send(self, count: int) -> None:
        """Sends `count` further missions."""
        for _ in range(count):
            with self._lock:
                chosen = self._random.sample(self._vertices, 2)
            self._publish(MissionRequest(destination_vertices_id=chosen))

    def _publish(self, request: MissionRequest) -> None:
        with self._lock:
            self._last += 1
            self.open[self._last] = -1
            request.request_id = self._last
        request.header.stamp = rospy.Time.now()
        self._requests.publish(request)

    def _hear(self, status: MissionStatus) -> None:
        if status.state not in _OVER:
            self.open[status.request_id] = status.state
            return
        if self.open.pop(status.request_id, None) is not None:
            self.ended[status.state] += 1
            if status.state != MissionStatus.SUCCEEDED:
                self.reasons[status.reason] = self.reasons.get(status.reason, 0) + 1
            self.send(1)
