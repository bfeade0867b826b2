"""The route driver on ROS: it publishes routes and receives reports and refusals.

Publishes target_route (itrci_nav_msgs/TargetRoute). Subscribes execution_route_states
(itrci_nav_msgs/ExecutionRouteStates), route_refused (itrci_nav_msgs/RouteRefused) and /graph
(itrci_nav_msgs/Graph).
"""
from __future__ import annotations

from typing import Callable, Dict

import rospy

from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import ExecutionRouteStates, RouteRefused, TargetRoute
from route_protocol.messages import refusal_of
from route_protocol.values import reason_of
from trajectory_graph import Graph
from vda5050_vehicle.drivers.route_driver import RouteDriver
from vda5050_vehicle.drivers.route_messages import RouteCommand, RouteReport

Tell = Callable[[Callable[[float], None]], None]  # executes a call in the vehicle's thread


class RouteLink:
    """Publishes the driver's commands, and passes the answers to it in the vehicle's thread."""

    def __init__(self, driver: RouteDriver, tell: Tell) -> None:
        self._driver = driver
        self._tell = tell
        self._stamps: Dict[RouteCommand, rospy.Time] = {}
        self._routes = rospy.Publisher('target_route', TargetRoute, queue_size=10,
                                       tcp_nodelay=True)
        rospy.Subscriber('execution_route_states', ExecutionRouteStates, self._on_states,
                         queue_size=10, tcp_nodelay=True)
        rospy.Subscriber('route_refused', RouteRefused, self._on_refused, queue_size=10,
                         tcp_nodelay=True)
        FollowedGraph(self._on_graph).subscribe()

    def carry_out(self, command: RouteCommand) -> None:
        """Publishes a route; a repetition has the same stamp, so that receivers count it once."""
        if command not in self._stamps:
            self._stamps = {command: rospy.Time.now()}
        message = TargetRoute(route_id=command.route_id, edges=list(command.edges),
                              known_epoch=command.known_epoch)
        message.header.stamp = self._stamps[command]
        self._routes.publish(message)

    def _on_states(self, message: ExecutionRouteStates) -> None:
        report = RouteReport(
            message.route_id, tuple(edge.state for edge in message.edge_states),
            message.symbolic_pose.edge_id, message.symbolic_pose.percentage,
            reason_of(message.reason_code, message.reason), message.epoch)
        self._tell(lambda now: self._driver.on_report(report, now))

    def _on_refused(self, message: RouteRefused) -> None:
        refusal = refusal_of(message)
        self._tell(lambda now: self._driver.on_refused(
            refusal.route_id, refusal.edges, refusal.reason, now))

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        self._tell(lambda now: self._driver.use_graph(graph))
