"""The rules for orders that each robot refuses, regardless of its type and position."""
from __future__ import annotations

from typing import Sequence, Tuple

from trajectory_graph.errors import TrajectoryGraphError
from trajectory_graph.graph import Graph
from trajectory_graph.route_protocol import EdgeState, Phase, Reason, ReasonCode, RouteOrder
from trajectory_graph.routes import check_route

MAXIMUM_EDGES = 1000
CLOCK_TOLERANCE = 1_000_000_000  # ns by which the sender's clock may be ahead of ours


class RouteRefused(Exception):
    """The order is refused; `reason` is for the fleet manager."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason.text)
        self.reason = reason


def check_order(order: RouteOrder, whose: str) -> None:
    """Raises RouteRefused for an order that is wrong for each graph and robot.

    whose -- name of the robot in the message
    """
    if len(order.edges) > MAXIMUM_EDGES:
        raise RouteRefused(Reason(ReasonCode.WRONG_ROUTE,
                                  f'the route has more than {MAXIMUM_EDGES} edges'))
    ahead = order.stamp - order.received
    if order.received and ahead > CLOCK_TOLERANCE:
        raise RouteRefused(Reason(
            ReasonCode.CLOCK, f'its stamp is {ahead / 1e9:.1f} s ahead of the clock of {whose}\'s '
                              'computer: synchronise the clocks (NTP)'))


def is_late(order: RouteOrder, last: RouteOrder) -> bool:
    """Returns whether the order was sent before the last accepted order, which overtook it.

    If this computer's clock is behind the stamp of the last accepted order, the clock was set back,
    and the stamps cannot be compared.
    """
    is_set_back = 0 < order.received < last.stamp - CLOCK_TOLERANCE
    return 0 < order.stamp < last.stamp and not is_set_back


def check_edges(graph: Graph, edges: Sequence[int]) -> None:
    """Raises RouteRefused for a route that no robot can drive."""
    try:
        check_route(graph, edges)
    except TrajectoryGraphError as error:
        raise RouteRefused(Reason(ReasonCode.WRONG_ROUTE, str(error).rstrip('.'))) from None


def edge_states(edges: Sequence[int], completed: int, phase: Phase) -> Tuple[EdgeState, ...]:
    """Returns one state for each edge of a route.

    completed -- number of driven edges, from the first one on
    """
    rest = EdgeState.FAILED if phase is Phase.FAILED else EdgeState.PROCESSING
    return (EdgeState.COMPLETE,) * completed + (rest,) * (len(edges) - completed)
