"""The rules for orders that each vehicle refuses, regardless of its type and position."""
from __future__ import annotations

from typing import Tuple

from route_protocol.values import EdgeState, Phase, Reason, ReasonCode, RouteOrder

MAXIMUM_EDGES = 1000
CLOCK_TOLERANCE = 1_000_000_000  # ns by which the sender's clock may be ahead of the receiver's


class RouteRefused(Exception):
    """The order is refused; `reason` is for the fleet manager."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason.text)
        self.reason = reason


def wrong_route(error: Exception) -> RouteRefused:
    """Returns the refusal of a route that no vehicle can drive on this graph."""
    return RouteRefused(Reason(ReasonCode.WRONG_ROUTE, str(error).rstrip('.')))


def check_order(order: RouteOrder, whose: str) -> None:
    """Raises RouteRefused for an order that is wrong for any graph and any vehicle.

    whose -- name of the vehicle in the message
    """
    if len(order.edges) > MAXIMUM_EDGES:
        raise RouteRefused(Reason(ReasonCode.WRONG_ROUTE,
                                  f'the route has more than {MAXIMUM_EDGES} edges'))
    ahead = order.stamp - order.received
    if order.received and ahead > CLOCK_TOLERANCE:
        raise RouteRefused(Reason(
            ReasonCode.CLOCK, f'its stamp is {ahead / 1e9:.1f} s ahead of the clock of {whose}\'s '
                              'computer: synchronise the clocks (NTP)'))


def edge_states(edges: Tuple[int, ...], completed: int, phase: Phase) -> Tuple[EdgeState, ...]:
    """Returns one state for each edge of a route.

    completed -- how many edges at the beginning of the route have been driven
    """
    rest = EdgeState.FAILED if phase is Phase.FAILED else EdgeState.PROCESSING
    return (EdgeState.COMPLETE,) * completed + (rest,) * (len(edges) - completed)
