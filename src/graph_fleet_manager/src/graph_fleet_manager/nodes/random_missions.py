"""random_missions: keeps a fleet busy, for demonstrations and endurance tests.

There are always as many open missions as robots that could serve one; each leads over some places
of the graph, at random.

Subscribes
    /graph (itrci_nav_msgs/Graph), /fleet_state (itrci_nav_msgs/FleetState): latched
    /mission_status (itrci_nav_msgs/MissionStatus)
Publishes
    /mission_request (itrci_nav_msgs/MissionRequest)
Parameters
    ~seed          int  0  of all that is random; 0: another one each time
    ~destinations  int  2  most destinations of a mission
    ~missions      int  0  so many in all, then no more; 0: without end
"""
from __future__ import annotations

import random
import threading
from typing import Dict, List

import rospy

from itrci_nav_msgs.msg import FleetRobot, FleetState, Graph, MissionRequest, MissionStatus
from node_lifecycle import parameter, run

PERIOD = 1.0  # s between two looks
REPEAT = 5.0  # s after which a request without any answer is sent again, unchanged
_OVER = frozenset((MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED,
                   MissionStatus.CANCELLED))
_WORKING = frozenset((FleetRobot.IDLE, FleetRobot.BUSY))


class RandomMissions:
    """The node: see the module's text."""

    def __init__(self) -> None:
        seed = parameter('~seed', 0, int)
        self._random = random.Random(seed or None)
        self._most = max(parameter('~destinations', 2, int), 1)
        self._left = parameter('~missions', 0, int) or -1
        self._lock = threading.Lock()
        self._places: List[int] = []
        self._robots = 0
        self._open: Dict[int, MissionRequest] = {}
        self._acknowledged: Dict[int, bool] = {}
        self._ended: Dict[int, int] = dict.fromkeys(_OVER, 0)
        self._requests = rospy.Publisher('/mission_request', MissionRequest, queue_size=100)
        rospy.Subscriber('/graph', Graph, self._on_graph, queue_size=1)
        rospy.Subscriber('/fleet_state', FleetState, self._on_state, queue_size=1)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=100)
        self._timer = rospy.Timer(rospy.Duration(PERIOD), self._tick)

    def _on_graph(self, message: Graph) -> None:
        with self._lock:
            self._places = [vertex.id for vertex in message.vertices
                            if not vertex.no_parking and not vertex.dock]

    def _on_state(self, message: FleetState) -> None:
        with self._lock:
            self._robots = sum(robot.state in _WORKING for robot in message.robots)

    def _on_status(self, message: MissionStatus) -> None:
        with self._lock:
            if message.request_id not in self._open:
                return
            self._acknowledged[message.request_id] = True
            if message.state in _OVER:
                del self._open[message.request_id], self._acknowledged[message.request_id]
                self._ended[message.state] += 1
                rospy.loginfo('Missions: %d succeeded, %d failed, %d refused, %d cancelled.',
                              *(self._ended[state] for state in (
                                  MissionStatus.SUCCEEDED, MissionStatus.FAILED,
                                  MissionStatus.REFUSED, MissionStatus.CANCELLED)))

    def _tick(self, _event: rospy.timer.TimerEvent) -> None:
        with self._lock:
            if not self._requests.get_num_connections() or len(self._places) < 2:
                return
            now = rospy.Time.now()
            for request_id, request in self._open.items():
                if not self._acknowledged.get(request_id) and (
                        now - request.header.stamp).to_sec() > REPEAT:
                    self._requests.publish(request)
            while len(self._open) < self._robots and self._left:
                request = self._request(now)
                self._open[request.request_id] = request
                self._requests.publish(request)
                self._left -= 1

    def _request(self, now: rospy.Time) -> MissionRequest:
        count = self._random.randint(1, min(self._most, len(self._places)))
        request = MissionRequest(request_id=random.SystemRandom().randint(1, 2 ** 31 - 1),
                                 destination_vertices_id=self._random.sample(self._places, count))
        request.header.stamp = now
        return request


def main() -> None:
    """Runs the node."""
    run('random_missions', RandomMissions)
