"""The rules of docs/reference/route_protocol.md that decide which orders a vehicle accepts."""
from __future__ import annotations

from typing import Optional, Tuple

from graph_fleet_manager.agv_simulator.drive import Drive
from route_protocol import order_rules
from route_protocol.order_rules import RouteRefused, wrong_route
from route_protocol.values import Phase, Reason, ReasonCode, RouteOrder
from route_protocol.vehicle import VehicleState
from trajectory_graph import TrajectoryGraphError, check_route


class NotYet(Exception):
    """The order cannot be judged before the vehicle stands still."""


def check_order(order: RouteOrder, drive: Drive) -> None:
    """Raises RouteRefused for an order that is wrong regardless of the vehicle's place."""
    order_rules.check_order(order, 'the vehicle')
    try:
        check_route(drive.graph, order.edges)
    except TrajectoryGraphError as error:
        raise wrong_route(error) from None
    for edge in order.edges:
        if not drive.speeds.may_drive(edge):
            raise _wrong(f'edge {edge} is not for driving this way: its speed is 0')


def check_change(order: RouteOrder, state: VehicleState) -> None:
    """Raises RouteRefused if an order without a number cannot change the route with its id so."""
    if state.phase is Phase.FAILED:
        raise RouteRefused(Reason(
            ReasonCode.WRONG_CHANGE,
            f'route {order.route_id} has failed: another one needs another id'))
    kept = state.edges[:state.completed + 1]
    if order.edges[:len(kept)] != kept:
        raise RouteRefused(Reason(
            ReasonCode.WRONG_CHANGE, f'route {order.route_id} must go on with the edges done and '
                                     f'the current one, {list(kept)}'))


def find_start(edges: Tuple[int, ...], state: VehicleState, drive: Drive) -> Tuple[int, float]:
    """The index of the edge, and the m on it, at which a vehicle begins a new route.

    A route may begin at the first vertex of the first edge, or on that edge. If the vehicle has
    just left this edge for the second one, the route is accepted too, because the order may have
    crossed with a report. Raises RouteRefused, and NotYet while the vehicle brakes and the route
    does not continue its motion.
    """
    going = _going_on(edges, state, drive)
    if going is not None and (drive.at_rest or state.is_running):
        check_braking(edges, drive, *going)
        return going
    if not drive.at_rest:
        if state.is_running:
            raise _elsewhere(f'the vehicle drives on edge {drive.edge}, with which the route '
                             'does not begin: stop it first, or let it end its route')
        raise NotYet
    first = edges[0]
    if drive.vertex is not None:
        if drive.graph.start_vertex(first).id == drive.vertex:
            return 0, 0.0
        ends = drive.graph.end_vertex(first).id == drive.vertex
        raise _elsewhere(f'edge {first} does not start where the vehicle is'
                         + (', but ends there' if ends else '') + f', at vertex {drive.vertex}')
    if drive.edge is not None and first == -drive.edge:
        return 0, drive.graph.curve(first).length - drive.arc
    raise _elsewhere(f'edge {first} does not start where the vehicle is: on edge {drive.edge}')


def _going_on(edges: Tuple[int, ...], state: VehicleState,
              drive: Drive) -> Optional[Tuple[int, float]]:
    """The index in the route of the vehicle's edge, and the m on it; None if it does not begin
    there."""
    if drive.edge is None or drive.at_end:
        return None
    if edges[0] == drive.edge:
        return 0, drive.arc
    if state.is_running and drive.index > 0 and (
            edges[:2] == drive.path[drive.index - 1:drive.index + 1]):
        return 1, drive.arc
    return None


def check_braking(edges: Tuple[int, ...], drive: Drive, index: int, arc: float) -> None:
    """Raises RouteRefused if the vehicle is too fast for this route."""
    if not drive.can_follow(edges, index, arc):
        raise RouteRefused(Reason(
            ReasonCode.CANNOT_BRAKE, f'at {drive.speed:.2f} m/s the vehicle cannot stop where the '
                                     'route demands it'))


def _wrong(text: str) -> RouteRefused:
    return RouteRefused(Reason(ReasonCode.WRONG_ROUTE, text))


def _elsewhere(text: str) -> RouteRefused:
    return RouteRefused(Reason(ReasonCode.STARTS_ELSEWHERE, text))
