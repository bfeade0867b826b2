"""Checks orders with the rules of docs/reference/route_protocol.md that only a vehicle can check.
"""
from __future__ import annotations

from typing import Tuple

from fleet_simulation.agv.drive import AgvMotion
from route_protocol import order_rules
from route_protocol.order_rules import RouteRefused, wrong_route
from route_protocol.values import Phase, Reason, ReasonCode, RouteOrder
from route_protocol.vehicle import VehicleState
from trajectory_graph import Graph, TrajectoryGraphError, check_drivable
from trajectory_graph.drawn_names import at_vertex, drawn_ids, edge_name
from trajectory_graph.id_lists import listed


def check_order(order: RouteOrder, drive: AgvMotion) -> None:
    """Raises RouteRefused for an order that is wrong regardless of the vehicle's place."""
    order_rules.check_order(order, 'the vehicle')
    try:
        check_drivable(drive.graph, order.edges)
    except TrajectoryGraphError as error:
        raise wrong_route(error) from None


def check_change(state: VehicleState, order: RouteOrder, graph: Graph) -> None:
    """Raises RouteRefused if an order without a number cannot change the route of the same id.

    The order must begin with the completed edges of the route and its present edge.
    """
    if state.phase is Phase.FAILED:
        raise RouteRefused(Reason(
            ReasonCode.WRONG_CHANGE,
            f'route {order.route_id} has failed: a new route needs another id'))
    kept = state.edges[:state.completed + 1]
    if order.edges[:len(kept)] != kept:
        raise RouteRefused(Reason(
            ReasonCode.WRONG_CHANGE, f'route {order.route_id} must go on with the edges done and '
                                     f'the current one: {listed(drawn_ids(graph, kept))}'))


def has_just_left(edges: Tuple[int, ...], state: VehicleState) -> bool:
    """Returns whether a new route without numbers begins with the edge that the vehicle has just
    left.

    This happens if the master sent the order before it received the newest report.
    """
    done = state.completed
    return (state.is_running and done > 0 and edges[0] != state.edges[done]
            and edges[:2] == state.edges[done - 1:done + 1])


def find_start(edges: Tuple[int, ...], state: VehicleState, drive: AgvMotion) -> float:
    """Returns how far (m) along the first of these edges the vehicle is now.

    Raises RouteRefused if the vehicle is not on this edge and not at its start, or if the vehicle
    cannot brake in time.
    """
    first = edges[0]
    going_on = drive.arc if first == drive.edge and not drive.at_end else None
    if going_on is not None:
        _check_braking(edges, drive, going_on)
        return going_on
    if not drive.at_rest:
        what_to_do = 'stop it first, or let it end its route' if state.is_running else (
            'let it come to rest first')
        raise _elsewhere(f'the vehicle drives on {_place(drive)}, with which the route does not '
                         f'begin: {what_to_do}')
    if drive.vertex is not None:
        if drive.graph.start_vertex(first).id == drive.vertex:
            return 0.0
        ends = drive.graph.end_vertex(first).id == drive.vertex
        raise _elsewhere(f'{edge_name(drive.graph, first)} does not start where the vehicle is'
                         + (', but ends there' if ends else '')
                         + f', {at_vertex(drive.graph, drive.vertex)}')
    if drive.edge is not None and first == -drive.edge:
        return drive.graph.curve(first).length - drive.arc
    raise _elsewhere(f'{edge_name(drive.graph, first)} does not start where the vehicle is: on '
                     f'{_place(drive)}')


def _place(drive: AgvMotion) -> str:
    return 'no edge' if drive.edge is None else edge_name(drive.graph, drive.edge)


def _check_braking(edges: Tuple[int, ...], drive: AgvMotion, arc: float) -> None:
    if not drive.can_follow(edges, 0, arc):
        raise RouteRefused(Reason(
            ReasonCode.CANNOT_BRAKE, f'at {drive.speed:.2f} m/s the vehicle cannot stop where the '
                                     'route demands it'))


def _elsewhere(text: str) -> RouteRefused:
    return RouteRefused(Reason(ReasonCode.STARTS_ELSEWHERE, text))
