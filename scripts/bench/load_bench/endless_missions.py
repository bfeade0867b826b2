"""Keeps so many missions open: for each that ends another one is sent."""
from __future__ import annotations

import threading
from random import Random
from typing import Dict, Sequence

import rospy

from itrci_nav_msgs.msg import MissionRequest, MissionStatus
from system_support import connected_publisher

_OVER = frozenset((MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED,
                   MissionStatus.CANCELLED))


class EndlessMissions:
    """Missions over two of these vertices, at random."""

    def __init__(self, vertices: Sequence[int]) -> None:
        self._vertices, self._random, self._last = vertices, Random(1), 0
        self._lock = threading.Lock()
        self.open: Dict[int, int] = {}
        """State by request id."""
        self.ended = dict.fromkeys(_OVER, 0)
        self.reasons: Dict[str, int] = {}
        rospy.Subscriber('/mission_status', MissionStatus, self._hear)
        self._requests = connected_publisher('/mission_request', MissionRequest,
                                             to='path_supervisor')

    def send(self, count: int) -> None:
        """So many more."""
        for _ in range(count):
            with self._lock:
                self._last += 1
                self.open[self._last] = -1
                request = MissionRequest(request_id=self._last,
                                         destination_vertices_id=self._random.sample(
                                             self._vertices, 2))
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
