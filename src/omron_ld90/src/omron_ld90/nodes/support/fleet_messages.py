"""The one place where the fleet manager's messages about routes become ours and back.

The original definitions of INESC TEC (itrci_nav_msgs) are not public; adapting to another one is
this file, and `trajectory_graph.messages` for the graph.
"""
from __future__ import annotations

import genpy

from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    RouteRefused,
    SymbolicPose,
    TargetRoute,
)
from omron_ld90.bridge.route_protocol import RouteOrder, RouteRefusal, RouteReport


def order_of(message: TargetRoute, received: genpy.Time) -> RouteOrder:
    """What a target route orders that was `received` now."""
    return RouteOrder(message.route_id, tuple(message.edges), message.header.stamp.to_nsec(),
                      received.to_nsec())


def refusal_of(refusal: RouteRefusal, now: genpy.Time) -> RouteRefused:
    """An order that is not taken up, as the fleet manager reads it."""
    message = RouteRefused(route_id=refusal.route_id, edges=list(refusal.edges),
                           reason=refusal.reason)
    message.header.stamp = now
    return message


def states_of(report: RouteReport) -> ExecutionRouteStates:
    """A report as the fleet manager reads it."""
    message = ExecutionRouteStates()
    message.header.stamp = genpy.Time(0, report.stamp)
    message.header.stamp.canon()
    message.header.frame_id = 'map'
    message.route_id = report.route_id
    message.edge_states = [EdgeState(edge, int(state))
                           for edge, state in zip(report.edges, report.states)]
    message.symbolic_pose = SymbolicPose(report.pose.edge, report.pose.percentage)
    message.reason = report.reason
    return message
