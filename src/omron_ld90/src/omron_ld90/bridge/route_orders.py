"""Checks orders against the graph and the last route."""
from __future__ import annotations

from typing import Optional, Tuple

from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.route_run import RouteRun
from route_protocol.intake import DueOrder
from route_protocol.order_rules import RouteRefused, wrong_route
from route_protocol.values import Phase, Reason, ReasonCode, RouteOrder
from route_protocol.vehicle import VehicleState
from trajectory_graph import Graph, TrajectoryGraphError, change_of, check_drivable
from trajectory_graph.drawn_names import at_vertex, drawn_ids, edge_name
from trajectory_graph.id_lists import listed


def check_edges(graph: Graph, edges: Tuple[int, ...]) -> None:
    """Raises RouteRefused if the edges do not exist or do not join, or if the graph forbids driving
    over one of them in this direction.
    """
    try:
        check_drivable(graph, edges)
    except TrajectoryGraphError as error:
        raise wrong_route(error) from None


def check_change(order: RouteOrder, state: VehicleState, route: Optional[RouteRun],
                 here: GraphLocation) -> None:
    """Raises RouteRefused if an order without a number cannot change the route of the same id."""
    if state.phase is Phase.FAILED:
        raise _refused(ReasonCode.WRONG_CHANGE,
                       f'route {order.route_id} has failed: a new route needs a new id')
    if route is None or route.progress.graph is not here.graph:
        raise _refused(ReasonCode.GRAPH_CHANGED,
                       f'the graph was replaced, and edges of route {order.route_id} are not '
                       'what they were: a new route needs a new id')
    if not route.decides_pose(here):
        raise _refused(ReasonCode.STARTS_ELSEWHERE,
                       f'route {order.route_id} ended '
                       f'{at_vertex(here.graph, route.progress.end(-1).id)}, but the robot is no '
                       'longer there')
    kept = state.edges[:state.completed + 1]
    if order.edges[:len(kept)] != kept:
        raise _refused(ReasonCode.WRONG_CHANGE,
                       f'route {order.route_id} must go on with the edges done and the '
                       f'current one: {listed(drawn_ids(here.graph, kept))}')


def check_braking(due: DueOrder, state: VehicleState, route: RouteRun, now: float) -> None:
    """Raises RouteRefused if the robot cannot stop before the first edge that the order removes."""
    kept = 0
    for before, after in zip(state.ahead, due.rest):
        if before != after:
            break
        kept += 1
    if kept < len(state.ahead) and not route.can_stop_within(kept, now):
        raise _refused(ReasonCode.CANNOT_BRAKE,
                       'the robot cannot stop before '
                       f'{edge_name(route.progress.graph, state.ahead[kept])}, which it takes '
                       'away')


def check_start(first: int, route: Optional[RouteRun], here: GraphLocation) -> None:
    """Raises RouteRefused if a new route that begins with the edge `first` does not start `here`.

    route -- the previous route
    """
    why_not = here.why_not_from(first, being_driven=route is not None and route.is_on(first))
    if why_not:
        raise _refused(ReasonCode.STARTS_ELSEWHERE, why_not)


def _refused(code: ReasonCode, text: str) -> RouteRefused:
    return RouteRefused(Reason(code, text))


def first_change(graph: Graph, other: Graph, edges: Tuple[int, ...]) -> str:
    """Compares `edges` in the graphs `other` and `graph`. Returns a clause about the first change.

    Empty: all edges are the same, except perhaps for their speeds.
    """
    return next((f'{edge_name(other, abs(edge))} {change}' for edge in edges
                 for change in [change_of(other, graph, edge)] if change), '')
