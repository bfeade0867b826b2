"""The messages of the bridge's reports and refusals carry all fields of the route protocol."""
from __future__ import annotations

import math

from itrci_nav_msgs import msg
from omron_ld90.bridge.events import LinkReported, MotionTold, RobotLink, RobotSeen
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_strategies import RouteSettings
from route_protocol.messages import fill_order, fill_refusal, fill_report, order_of
from route_protocol.values import EpochCause, Motion, ReasonCode, RouteOrder, RouteRefusal
from trajectory_graph import Edge, Graph, Vertex

GRAPH = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 4.0, 0.0, 0.0)],
              [Edge(1, 1, 2, velocity_forward=1.0, velocity_backwards=1.0)])
EPOCH = 2 ** 63 - 1


def follower() -> RouteFollower:
    """Returns a bridge whose robot stands at vertex 1."""
    bridge = RouteFollower(RouteSettings(), GRAPH, tuple(RobotLink), lambda: EPOCH, lambda: 5000)
    for link in RobotLink:
        bridge.handle(LinkReported(link, True), 0.0)
    bridge.handle(MotionTold(1), 0.0)
    for second in range(3):
        bridge.handle(RobotSeen((second + 1) * 10 ** 9, place=(0.0, 0.0), heading=0.5),
                      float(second))
    return bridge


def heard(order: RouteOrder) -> RouteOrder:
    """Writes an order into a message. Returns the order that the node reads from it."""
    return order_of(fill_order(msg.TargetRoute(), order), 0)


def test_a_report_carries_all_fields():
    bridge = follower()
    bridge.handle(heard(RouteOrder(7, (1,), known_epoch=EPOCH, order=2 ** 50, first=2 ** 31,
                                   master='/fleet')), 2.0)
    bridge.handle(heard(RouteOrder(7, (1, 9), known_epoch=EPOCH, order=2 ** 51, first=2 ** 31,
                                   master='/fleet')), 2.0)
    sent = fill_report(msg.ExecutionRouteStates(), bridge.report(), msg.EdgeState)
    assert (sent.epoch, sent.epoch_cause, sent.master) == (EPOCH, EpochCause.RESTART, '/fleet')
    assert (sent.order, sent.refused, sent.first) == (2 ** 50, 2 ** 51, 2 ** 31)
    assert (sent.refusal, sent.refusal_code) == ('The graph has no edge 9', ReasonCode.WRONG_ROUTE)
    assert (sent.motion, sent.x, sent.y, sent.theta) == (Motion.ON_ROUTE, 0.0, 0.0, 0.5)
    assert sent.report >= 5000


def test_a_report_without_a_location_has_none():
    sent = fill_report(msg.ExecutionRouteStates(), RouteFollower(RouteSettings()).report(),
                       msg.EdgeState)
    assert math.isnan(sent.x) and sent.motion == Motion.UNKNOWN
    assert sent.epoch


def test_a_refusal_carries_the_number_of_the_order():
    actions = follower().handle(heard(RouteOrder(7, (9,), known_epoch=EPOCH, order=6,
                                                 master='/fleet')), 2.0)
    refusal, = (action for action in actions if isinstance(action, RouteRefusal))
    assert fill_refusal(msg.RouteRefused(), refusal, 0).order == 6
