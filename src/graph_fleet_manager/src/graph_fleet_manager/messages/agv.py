"""What a simulated AGV is told and tells."""
from __future__ import annotations

import genpy

from graph_fleet_manager.route_protocol import RouteOrder, RouteRefusal, RouteReport
from itrci_nav_msgs import msg


def order_of(message: msg.TargetRoute, received: genpy.Time) -> RouteOrder:
    """What a target route orders that was `received` now."""
    return RouteOrder(message.route_id, tuple(message.edges), message.header.stamp.to_nsec(),
                      received.to_nsec())


def refusal_message(refusal: RouteRefusal, now: genpy.Time) -> msg.RouteRefused:
    """An order that was not taken up."""
    message = msg.RouteRefused(route_id=refusal.route_id, edges=list(refusal.edges),
                               reason=refusal.reason)
    message.header.stamp = now
    return message


def report_message(report: RouteReport) -> msg.ExecutionRouteStates:
    """How far a route is."""
    message = msg.ExecutionRouteStates()
    message.header.stamp = genpy.Time(0, report.stamp)
    message.header.stamp.canon()
    message.header.frame_id = 'map'
    message.route_id = report.route_id
    message.edge_states = [msg.EdgeState(edge, int(state))
                           for edge, state in zip(report.edges, report.states)]
    message.symbolic_pose = msg.SymbolicPose(report.pose.edge, report.pose.percentage)
    message.reason = report.reason
    return message
