"""The route driver on ROS: it publishes orders and receives reports.

Publishes target_route (itrci_nav_msgs/TargetRoute). Subscribes execution_route_states
(itrci_nav_msgs/ExecutionRouteStates) and /graph (itrci_nav_msgs/Graph).
"""
from __future__ import annotations

from typing import Callable, Tuple

import rospy

from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import ExecutionRouteStates, TargetRoute
from route_protocol.master import Order
from route_protocol.messages import WrongReport, check_report, fill_order, report_of
from trajectory_graph import Graph
from vda5050_vehicle.drivers.route_driver import ME, RouteDriver

Tell = Callable[[Callable[[float], None]], None]  # executes a call in the vehicle's thread


class RouteLink:
    """Publishes the driver's orders, and passes the reports to it in the vehicle's thread."""

    def __init__(self, driver: RouteDriver, tell: Tell) -> None:
        self._driver = driver
        self._tell = tell
        self._sent: Tuple[int, int] = (0, 0)  # number of the last order, and its stamp in ns
        self._routes = rospy.Publisher('target_route', TargetRoute, queue_size=10,
                                       tcp_nodelay=True)
        rospy.Subscriber('execution_route_states', ExecutionRouteStates, self._on_states,
                         queue_size=10, tcp_nodelay=True)
        FollowedGraph(self._on_graph).subscribe()

    def carry_out(self, order: Order) -> None:
        """Publishes an order; a repetition has the stamp of the first message."""
        if order.number != self._sent[0]:
            self._sent = order.number, rospy.Time.now().to_nsec()
        self._routes.publish(fill_order(TargetRoute(), order.sent_by(ME, self._sent[1])))

    def _on_states(self, message: ExecutionRouteStates) -> None:
        self._tell(lambda now: self._hear(message, now))

    def _hear(self, message: ExecutionRouteStates, now: float) -> None:
        try:
            said = report_of(message)
            check_report(said)
            self._driver.on_report(said, now)
        except WrongReport as wrong:
            rospy.logwarn_throttle(10.0, 'A report in execution_route_states is ignored: %s.',
                                   wrong)

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        self._tell(lambda now: self._driver.use_graph(graph))
