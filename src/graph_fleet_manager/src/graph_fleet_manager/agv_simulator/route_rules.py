"""The rules of docs/reference/route_protocol.md that decide which orders a vehicle accepts."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from graph_fleet_manager.agv_simulator.drive import Drive
from trajectory_graph import order_rules
from trajectory_graph.id_lists import listed
from trajectory_graph.order_rules import RouteRefused, check_edges, edge_states
from trajectory_graph.route_protocol import (
    NO_REASON,
    EdgeState,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
)


class NotYet(Exception):
    """The order cannot be judged before the vehicle stands still."""


@dataclass
class Route:
    """An accepted order and its progress."""

    order: RouteOrder
    phase: Phase = Phase.RUNNING
    completed: int = 0
    reason: Reason = NO_REASON

    @property
    def running(self) -> bool:
        """Whether it is being driven."""
        return self.phase is Phase.RUNNING

    @property
    def edges(self) -> Tuple[int, ...]:
        """Signed ids, as ordered."""
        return self.order.edges

    @property
    def states(self) -> Tuple[EdgeState, ...]:
        """One state per edge."""
        return edge_states(self.edges, self.completed, self.phase)

    def is_changed_by(self, order: RouteOrder) -> bool:
        """Returns whether the order changes this route: same id, and the route was not stopped."""
        return self.order.route_id == order.route_id and self.phase is not Phase.STOPPED


def check_order(order: RouteOrder, drive: Drive) -> None:
    """Raises RouteRefused for an order that is wrong regardless of the vehicle's place."""
    order_rules.check_order(order, 'the vehicle')
    check_edges(drive.graph, order.edges)
    for edge in order.edges:
        if not drive.speeds.may_drive(edge):
            raise _wrong(f'edge {edge} is not for driving this way: its speed is 0')


def check_change(route: Route, order: RouteOrder, drive: Drive) -> None:
    """Raises RouteRefused if the order, which has the route's id, cannot change the route so."""
    if route.phase is Phase.FAILED:
        raise RouteRefused(Reason(
            ReasonCode.WRONG_CHANGE,
            f'route {order.route_id} has failed: another one needs another id'))
    kept = route.edges[:route.completed + 1]
    if order.edges[:len(kept)] != kept:
        raise RouteRefused(Reason(
            ReasonCode.WRONG_CHANGE, f'route {order.route_id} must go on with the edges done and '
                                     f'the current one: {listed(kept)}'))
    _check_braking(order, drive, drive.index, drive.arc)


def find_start(order: RouteOrder, before: Optional[Route], drive: Drive) -> Tuple[int, float]:
    """The index of the edge, and the m on it, at which a vehicle begins a new route.

    A route may begin at the first vertex of the first edge, or on that edge. If the vehicle has
    just left this edge for the second one, the route is accepted too, because the order may have
    crossed with a report. Raises RouteRefused, and NotYet while the vehicle brakes and the route
    does not continue its motion.
    """
    going = _going_on(order, before, drive)
    if going is not None and (drive.at_rest or before is None or before.running
                              or drive.can_follow(order.edges, *going)):
        _check_braking(order, drive, *going)
        return going
    if not drive.at_rest:
        if before is not None and before.running:
            raise _elsewhere(f'the vehicle drives on edge {drive.edge}, with which the route '
                             'does not begin: stop it first, or let it end its route')
        raise NotYet
    first = order.edges[0]
    if drive.vertex is not None:
        if drive.graph.start_vertex(first).id == drive.vertex:
            return 0, 0.0
        ends = drive.graph.end_vertex(first).id == drive.vertex
        raise _elsewhere(f'edge {first} does not start where the vehicle is'
                         + (', but ends there' if ends else '') + f', at vertex {drive.vertex}')
    if drive.edge is not None and first == -drive.edge:
        return 0, drive.graph.curve(first).length - drive.arc
    raise _elsewhere(f'edge {first} does not start where the vehicle is: on edge {drive.edge}')


def _going_on(order: RouteOrder, before: Optional[Route],
              drive: Drive) -> Optional[Tuple[int, float]]:
    """The index in the route of the vehicle's edge, and the m on it; None if it does not begin
    there."""
    if drive.edge is None or drive.at_end:
        return None
    if order.edges[0] == drive.edge:
        return 0, drive.arc
    if (before is not None and before.running and drive.index > 0
            and order.edges[:2] == drive.path[drive.index - 1:drive.index + 1]):
        return 1, drive.arc
    return None


def _check_braking(order: RouteOrder, drive: Drive, index: int, arc: float) -> None:
    if not drive.can_follow(order.edges, index, arc):
        raise RouteRefused(Reason(
            ReasonCode.CANNOT_BRAKE, f'at {drive.speed:.2f} m/s the vehicle cannot stop where the '
                                     'route demands it'))


def _wrong(text: str) -> RouteRefused:
    return RouteRefused(Reason(ReasonCode.WRONG_ROUTE, text))


def _elsewhere(text: str) -> RouteRefused:
    return RouteRefused(Reason(ReasonCode.STARTS_ELSEWHERE, text))
