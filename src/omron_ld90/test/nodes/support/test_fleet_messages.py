"""The fleet manager's messages become domain objects and back, without loss."""
from __future__ import annotations

import genpy
import pytest

from itrci_nav_msgs.msg import Edge, Graph, TargetRoute, Vertex
from omron_ld90.bridge.route_protocol import EdgeState, RouteOrder, RouteReport, SymbolicPose
from omron_ld90.nodes.support.fleet_messages import graph_of, order_of, states_of
from trajectory_graph import CurveType, GraphError


def test_a_target_route_is_an_order():
    message = TargetRoute(route_id=7, edges=[3, -4])
    message.header.stamp = genpy.Time(12, 5)
    assert order_of(message) == RouteOrder(7, (3, -4), 12_000_000_005)


def test_a_report_keeps_the_stamp_to_the_nanosecond():
    report = RouteReport(1_795_263_724_236_859_123, 7, (3, -4),
                         (EdgeState.COMPLETE, EdgeState.FAILED), SymbolicPose(-4, 12.5), 'why')
    message = states_of(report)
    assert message.header.stamp.to_nsec() == report.stamp
    assert [(edge.edge_id, edge.state) for edge in message.edge_states] == [(3, 2), (-4, 3)]
    assert (message.route_id, message.reason) == (7, 'why')
    assert (message.symbolic_pose.edge_id, message.symbolic_pose.percentage) == (-4, 12.5)


def graph_message(curve_type: str) -> Graph:
    return Graph(
        vertices=[Vertex(id=1, x=0.0, y=0.0, frame_id='map/nn0', label='pass'),
                  Vertex(id=2, x=4.0, y=0.0, frame_id='map/nn0', theta=1.5)],
        edges=[Edge(id=3, origin_id=1, destination_id=2, curve_type=curve_type, param_f=0.25,
                    param_b=0.5, velocity_forward=0.3, velocity_backwards=0.1)])


def test_a_graph_message_is_a_graph():
    graph = graph_of(graph_message('spline'))
    edge = graph.edge(3)
    assert (edge.origin, edge.destination, edge.curve_type) == (1, 2, CurveType.SPLINE)
    assert (edge.param_f, edge.param_b, edge.velocity_backwards) == (0.25, 0.5, 0.1)
    assert graph.vertex(2).theta == 1.5


def test_a_curve_type_that_nobody_knows_is_refused():
    with pytest.raises(GraphError, match="edge 3: curve_type is 'clothoid'"):
        graph_of(graph_message('clothoid'))
