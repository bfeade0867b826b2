"""random_missions: keeps a fleet busy, for demonstrations and endurance tests.

For each robot that could serve a mission, it keeps one mission open. Each mission has random
destinations in a connected part of the graph that contains one of these robots.

Subscribes
    /graph (itrci_nav_msgs/Graph), /fleet_state (itrci_nav_msgs/FleetState): latched
    /mission_status (itrci_nav_msgs/MissionStatus)
Publishes
    /mission_request (itrci_nav_msgs/MissionRequest)
Calls
    /get_mission_status (itrci_nav_msgs/GetMissionStatus), if a mission has no news for long
Parameters
    ~seed          int  0  seed of all random numbers; 0: a new one each time
    ~destinations  int  2  largest number of destinations of a mission
    ~missions      int  0  number of missions to send in all; 0: without end
"""
from __future__ import annotations

import random
import threading
import time
from typing import Dict, List, NamedTuple

import rospy

from fleet_requests import MissionNews, Sender, mission_request, stored_status
from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionRequest, MissionStatus
from node_lifecycle import parameter, run
from node_lifecycle.periodic import Periodic
from trajectory_graph import Graph

PERIOD = 1.0  # s between two checks
REPEAT = 5.0  # s after which a request without any answer is sent again, unchanged
_OVER = frozenset((MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED,
                   MissionStatus.CANCELLED))
_WORKING = frozenset((FleetRobot.IDLE, FleetRobot.BUSY))


class _Sent(NamedTuple):
    """A request, and the monotonic time (s) at which it was first sent."""

    request: MissionRequest
    at: float


class RandomMissions:
    """The node; see the docstring of the module."""

    def __init__(self) -> None:
        seed = parameter('~seed', 0, int)
        self._random = random.Random(seed or None)
        self._most = max(parameter('~destinations', 2, int), 1)
        self._left = parameter('~missions', 0, int) or -1
        self._lock = threading.Lock()
        self._places: Dict[int, List[int]] = {}
        """By edge id: the possible destinations in the connected part of the graph with this edge.
        """
        self._robots: List[int] = []
        """One edge for each robot that could serve a mission: the edge on which the robot is."""
        self._open: Dict[int, _Sent] = {}
        self._news = MissionNews()
        self._ended: Dict[int, int] = dict.fromkeys(_OVER, 0)
        self._requests = Sender(MissionRequest)
        FollowedGraph(self._on_graph).subscribe()
        rospy.Subscriber('/fleet_state', FleetState, self._on_state, queue_size=1)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=100)
        Periodic('missions', PERIOD, self._tick)

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        with self._lock:
            self._places = places_by_edge(graph)

    def _on_state(self, message: FleetState) -> None:
        with self._lock:
            self._robots = [abs(robot.pose.edge_id) for robot in message.robots
                            if robot.state in _WORKING]

    def _on_status(self, message: MissionStatus) -> None:
        with self._lock:
            if message.request_id not in self._open:
                return
            self._news.heard(message.request_id)
            if message.state in _OVER:
                del self._open[message.request_id]
                self._news.ended(message.request_id)
                self._ended[message.state] += 1
                if message.state != MissionStatus.REFUSED:
                    self._fill()  # at once, so that no robot waits for the next check
                rospy.loginfo('Missions: %d succeeded, %d failed, %d refused, %d cancelled.',
                              *(self._ended[state] for state in (
                                  MissionStatus.SUCCEEDED, MissionStatus.FAILED,
                                  MissionStatus.REFUSED, MissionStatus.CANCELLED)))

    def _tick(self) -> None:
        self._ask()
        with self._lock:
            for request_id, sent in self._open.items():
                if request_id not in self._news and time.monotonic() - sent.at > REPEAT:
                    self._requests.repeat(sent.request)
            self._fill()

    def _fill(self) -> None:
        """Requests missions until there is one for each robot that works."""
        homes = [self._places[edge] for edge in self._robots if edge in self._places]
        if not self._requests.is_heard or not homes:
            return
        while len(self._open) < len(self._robots) and self._left:
            request = self._request(self._random.choice(homes))
            self._open[request.request_id] = _Sent(request, time.monotonic())
            self._requests.send(request)
            self._left -= 1

    def _ask(self) -> None:
        """Asks for the status of missions without news, because a message may have been lost."""
        with self._lock:
            requests = [self._open[id].request for id in self._news.silent()]
        for request in requests:
            answer = stored_status(request.request_id, request.header.stamp)
            if answer is not None and answer.found:
                self._on_status(answer.status)

    def _request(self, places: List[int]) -> MissionRequest:
        count = self._random.randint(1, min(self._most, len(places)))
        return mission_request(self._random.sample(places, count))


def places_by_edge(graph: Graph) -> Dict[int, List[int]]:
    """Returns for each edge id the possible destinations in the connected part of the graph that
    contains the edge.

    Docks and vertices where no robot may park are omitted. Parts with fewer than two destinations
    have no entries.
    """
    free = {vertex.id for vertex in graph.vertices.values()
            if vertex.parking is not False and not vertex.dock}
    found: Dict[int, List[int]] = {}
    for part in graph.parts:
        places = sorted(free & part)
        if len(places) > 1:
            found.update((edge.id, places) for edge in graph.edges.values() if edge.origin in part)
    return found


def main() -> None:
    """Runs the node."""
    run('random_missions', RandomMissions)
