"""Hundreds of robots in one process: they only report at 10 Hz and obey routes.

Some robots drive on rings of their own. For these robots, the time from a report to an order with
more edges is measured. The time begins with the first report that shows that the robot would soon
have to brake.
"""
from __future__ import annotations

import threading
import time
from typing import Dict, List, Mapping, NamedTuple, Optional

import rospy

from fleet_core.fleet import RobotType
from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates, RouteRefused, TargetRoute
from load_bench.site import ALONE, RELEASE_AHEAD
from route_protocol.messages import fill_refusal, fill_report, order_of
from trajectory_graph import Graph
from world.plain_agv import Agv

PERIOD = 0.1  # s between two reports of a robot
_SLICES = 10  # parts of a period; in each part, another tenth of the robots reports


class Release(NamedTuple):
    """More edges for a robot under the same route id.

    moment  -- time of arrival, s of the monotonic clock
    seconds -- seconds since the report that made the order due
    """

    moment: float
    seconds: float


class _Robot:
    """One robot, its topics, and the time of the first report that shows that it needs more edges.
    """

    def __init__(self, name: str, graph: Graph, kind: RobotType, vertex: int,
                 lock: threading.Lock) -> None:
        self.agv = Agv(graph, kind, vertex)
        self.told_at: Optional[float] = None
        self.releases: List[Release] = []
        self._lock = lock
        self._reports = rospy.Publisher(f'/{name}/execution_route_states', ExecutionRouteStates,
                                        queue_size=10, latch=True, tcp_nodelay=True)
        self._refusals = rospy.Publisher(f'/{name}/route_refused', RouteRefused, queue_size=10)
        rospy.Subscriber(f'/{name}/target_route', TargetRoute, self._on_route, queue_size=100,
                         tcp_nodelay=True)

    def _on_route(self, message: TargetRoute) -> None:
        came = time.monotonic()
        order = order_of(message, rospy.Time.now().to_nsec())
        with self._lock:
            agv = self.agv
            is_same, end = order.route_id == agv.route_id, agv.done + len(agv.ahead)
            refusal = agv.receive(order)
            is_longer = is_same and order.first + len(order.edges) > end
            if is_longer and self.told_at is not None:
                self.releases.append(Release(came, came - self.told_at))
            if not is_same or is_longer:
                self.told_at = None
        if refusal is not None:
            self._refusals.publish(fill_refusal(RouteRefused(), refusal,
                                                rospy.Time.now().to_nsec()))

    def _ahead(self) -> float:
        """Returns the length (m) of the part of the route that the robot has not driven yet."""
        agv = self.agv
        left = sum(agv.graph.curve(edge).length for edge in agv.edges[agv.current:])
        return left - (agv.arc if agv.is_driving else 0.0)

    def report(self, stamp: rospy.Time) -> None:
        """Publishes the robot's report."""
        with self._lock:
            agv = self.agv
            report = agv.report(stamp.to_sec())
            if agv.edges and self.told_at is None and self._ahead() <= RELEASE_AHEAD:
                self.told_at = time.monotonic()
        self._reports.publish(fill_report(ExecutionRouteStates(), report, EdgeState))


class LightFleet:
    """The robots; a thread of this object drives them."""

    def __init__(self, graph: Graph, places: Mapping[str, int]) -> None:
        self._lock = threading.Lock()
        kind = RobotType('agv', 0.43, 1.0)
        self._robots: Dict[str, _Robot] = {name: _Robot(name, graph, kind, vertex, self._lock)
                                           for name, vertex in places.items()}
        self.reports = 0
        self.latest = 0.0
        """The longest delay of a report so far (s)."""
        threading.Thread(target=self._drive, name='robots', daemon=True).start()

    def _drive(self) -> None:
        robots = list(self._robots.values())
        due = last = time.monotonic()
        number = 0
        while not rospy.is_shutdown():
            due += PERIOD / _SLICES
            now = time.monotonic()
            self.latest = max(self.latest, now - due)
            time.sleep(max(due - now, 0.0))
            if number == 0:
                now = time.monotonic()
                with self._lock:
                    for robot in robots:
                        robot.agv.drive(now - last)
                last = now
            stamp = rospy.Time.now()
            for robot in robots[number::_SLICES]:
                robot.report(stamp)
            self.reports += len(robots[number::_SLICES])
            number = (number + 1) % _SLICES

    @property
    def releases(self) -> List[Release]:
        """All releases so far for robots on rings."""
        with self._lock:
            return [release for name, robot in self._robots.items() if name.startswith(ALONE)
                    for release in robot.releases]

    @property
    def travelled(self) -> float:
        """Distance (m) that all robots have driven together."""
        return sum(robot.agv.travelled for robot in self._robots.values())
