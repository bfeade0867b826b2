"""Continues a route that was running when the bridge was restarted.

The robot may have driven on in the meantime.
"""
from __future__ import annotations

from typing import Callable, Optional

from omron_ld90.bridge.events import BridgeMemory
from omron_ld90.bridge.goal_tracker import RouteFailed
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.route_orders import check_edges
from omron_ld90.bridge.route_run import RouteRun
from route_protocol.order_rules import RouteRefused
from route_protocol.values import Reason, ReasonCode


def continued_route(record: BridgeMemory, here: GraphLocation,
                    run: Callable[[int], RouteRun], now: float) -> Optional[RouteRun]:
    """Returns the continued route of `record`. None: it had ended, and the graph lacks its edges.

    If the route had ended on this graph, only the position on it is restored. Raises RouteFailed if
    a running route cannot continue.

    run -- makes the route; its argument is the index of the current edge
    """
    state = record.vehicle
    try:
        check_edges(here.graph, state.edges)
    except RouteRefused as refusal:
        if state.is_running:
            raise RouteFailed(refusal.reason) from None
        return None
    if not state.is_running:
        return run(state.completed)
    current = _current_edge(record, here)
    route = run(current)
    if record.target is None:
        route.drive()
    else:
        route.resume(record.target, record.number, now)
    return route


def _current_edge(record: BridgeMemory, here: GraphLocation) -> int:
    """Returns the index of the edge on which the robot is. Raises RouteFailed if it is on no edge
    that leads to its last goal.

    All edges before the returned one have been driven.
    """
    completed = record.vehicle.completed
    last = completed if record.target is None else record.target
    ahead = record.vehicle.edges[completed:last + 1]
    if not ahead or here.is_about_the_dock:
        return completed
    found = here.nearest_of(ahead)
    if found is not None:
        return completed + found
    raise RouteFailed(Reason(
        ReasonCode.RESTARTED,
        'the robot was not on the route any more after a restart of the bridge'))
