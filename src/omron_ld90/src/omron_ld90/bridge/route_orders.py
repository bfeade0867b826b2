"""Checks orders against the graph and the last route."""
from __future__ import annotations

from typing import Optional, Tuple

from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.route_run import RouteRun
from trajectory_graph import Graph, change_of
from trajectory_graph.id_lists import listed
from trajectory_graph.order_rules import RouteRefused
from trajectory_graph.route_protocol import Phase, Reason, ReasonCode, RouteOrder


def is_change(route: RouteRun, order: RouteOrder) -> bool:
    """Whether the order has the id of a route that was not stopped."""
    return route.order.route_id == order.route_id and route.phase is not Phase.STOPPED


def check_change(route: RouteRun, order: RouteOrder, here: GraphLocation) -> None:
    """Raises RouteRefused if the route cannot be changed as the order with its id demands."""
    if route.phase is Phase.FAILED:
        raise _refused(ReasonCode.WRONG_CHANGE,
                       f'route {order.route_id} has failed: a new route needs a new id')
    if not route.is_on_graph or route.progress.graph is not here.graph:
        raise _refused(ReasonCode.GRAPH_CHANGED,
                       f'the graph was replaced, and edges of route {order.route_id} are not '
                       'what they were: a new route needs a new id')
    if not route.decides_pose(here):
        raise _refused(ReasonCode.STARTS_ELSEWHERE,
                       f'route {order.route_id} ended at vertex {route.progress.end(-1).id}, '
                       'but the robot is no longer there')
    kept = route.edges[:route.progress.current + 1]
    if order.edges[:len(kept)] != kept:
        raise _refused(ReasonCode.WRONG_CHANGE,
                       f'route {order.route_id} must go on with the edges done and the '
                       f'current one: {listed(kept)}')


def check_start(order: RouteOrder, route: Optional[RouteRun], here: GraphLocation) -> None:
    """Raises RouteRefused if a new route does not start `here`; `route` is the one before."""
    first = order.edges[0]
    why_not = here.why_not_from(first, being_driven=route is not None and route.is_on(first))
    if why_not:
        raise _refused(ReasonCode.STARTS_ELSEWHERE, why_not)


def _refused(code: ReasonCode, text: str) -> RouteRefused:
    return RouteRefused(Reason(code, text))


def first_change(graph: Graph, other: Graph, edges: Tuple[int, ...]) -> str:
    """A clause that says how `graph` changes the first changed edge of these `edges` of `other`.

    Empty if all are the same, except for their speeds.
    """
    return next((f'edge {abs(edge)} {change}' for edge in edges
                 for change in [change_of(other, graph, edge)] if change), '')
