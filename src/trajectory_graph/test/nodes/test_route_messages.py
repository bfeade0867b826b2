"""The fleet manager's messages become domain objects and back, without loss."""
from __future__ import annotations

import genpy

from itrci_nav_msgs.msg import EdgeState as EdgeStateMessage
from itrci_nav_msgs.msg import ExecutionRouteStates, RouteRefused, TargetRoute
from trajectory_graph.route_messages import fill_refusal, fill_report, order_of
from trajectory_graph.route_protocol import (
    EdgeState,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
)


def test_a_target_route_is_an_order():
    message = TargetRoute(route_id=7, edges=[3, -4])
    message.header.stamp = genpy.Time(12, 5)
    order = order_of(message, 13_000_000_000)
    assert order == RouteOrder(7, (3, -4), 12_000_000_005)
    assert order.received == 13_000_000_000


def test_a_refusal_names_the_order_and_the_reason():
    message = fill_refusal(RouteRefused(), RouteRefusal(7, (3, -4), 'no edge 3'), 13_000_000_000)
    assert (message.route_id, message.edges, message.reason) == (7, [3, -4], 'no edge 3')
    assert message.header.stamp == genpy.Time(13, 0)


def test_a_report_keeps_the_stamp_to_the_nanosecond():
    report = RouteReport(1_795_263_724_236_859_123, 7, (3, -4),
                         (EdgeState.COMPLETE, EdgeState.FAILED), SymbolicPose(-4, 12.5), 'why')
    message = fill_report(ExecutionRouteStates(), report, EdgeStateMessage)
    assert message.header.stamp.to_nsec() == report.stamp
    assert [(edge.edge_id, edge.state) for edge in message.edge_states] == [(3, 2), (-4, 3)]
    assert (message.route_id, message.reason) == (7, 'why')
    assert (message.symbolic_pose.edge_id, message.symbolic_pose.percentage) == (-4, 12.5)
