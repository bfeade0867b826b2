"""Which orders can be driven, as what, and where a route goes on after a restart."""
from __future__ import annotations

from typing import Optional

from omron_ld90.bridge.route_place import PlaceOnGraph
from omron_ld90.bridge.route_protocol import RouteOrder, RouteRecord
from omron_ld90.bridge.route_run import Phase, RouteRun
from trajectory_graph import Graph, TrajectoryGraphError, check_route

LONGEST_ROUTE = 10_000  # edges


class RouteRefused(Exception):
    """The order is not taken up; the text, a clause, is the reason for the fleet manager."""


def check_fit(graph: Graph, order: RouteOrder) -> None:
    """Raises RouteRefused for a route that no robot could drive."""
    if len(order.edges) > LONGEST_ROUTE:
        raise RouteRefused(f'the route has more than {LONGEST_ROUTE} edges')
    try:
        check_route(graph, order.edges)
    except TrajectoryGraphError as error:
        raise RouteRefused(str(error).rstrip('.')) from None


def is_change(route: Optional[RouteRun], order: RouteOrder) -> bool:
    """Does the order have the id of a route that was not stopped?"""
    return (route is not None and route.order.route_id == order.route_id
            and route.phase is not Phase.STOPPED)


def check_change(route: RouteRun, order: RouteOrder, here: PlaceOnGraph) -> None:
    """Raises RouteRefused where the route cannot become what the order of the same id says."""
    if route.phase is Phase.FAILED:
        raise RouteRefused(f'route {order.route_id} has failed: another one needs another id')
    if route.progress.graph is not here.graph:
        raise RouteRefused(f'the graph was replaced, and edges of route {order.route_id} are not '
                           'what they were: another one needs another id')
    if not route.decides_pose(here):
        raise RouteRefused(f'route {order.route_id} ended at vertex {route.progress.end(-1).id}, '
                           'where the robot no longer is')
    kept = route.edges[:route.progress.current + 1]
    if order.edges[:len(kept)] != kept:
        raise RouteRefused(f'route {order.route_id} must go on with the edges done and the '
                           f'current one, {list(kept)}')


def first_index(order: RouteOrder, route: Optional[RouteRun], record: Optional[RouteRecord],
                here: PlaceOnGraph) -> int:
    """Index of the edge with which the order begins: 0, or where it was before a restart.

    Raises RouteRefused where it does not start `here`. `route` is the one before it.
    """
    current = resumed_at(order, record, here) if record else None
    if current is not None:
        return current
    first = order.edges[0]
    reason = here.why_not_from(first, being_driven=route is not None and route.is_on(first))
    if reason:
        raise RouteRefused(reason)
    return 0


def resumed_at(order: RouteOrder, record: RouteRecord, here: PlaceOnGraph) -> Optional[int]:
    """Index of the edge from which the route goes on that ran before a restart of this program.

    len(order.edges) when it was complete already; None when it was another route, or the robot is
    elsewhere. Meanwhile the robot went on to the vertex that it had been sent to. Nothing else sent
    it anywhere as long as it is found on the edges that lead there; those behind it were driven.
    """
    kept = record.edges[:record.completed + 1]
    if record.route_id != order.route_id or order.edges[:len(kept)] != kept:
        return None
    ahead = order.edges[record.completed:record.target + 1]
    if not ahead or here.is_about_the_dock:
        return record.completed
    found = here.nearest_of(ahead)
    return None if found is None else record.completed + found


def is_same_in(graph: Graph, route: RouteRun) -> bool:
    """Are the route's edges, their vertices included, in another graph what they were?"""
    known = route.progress.graph
    return all(abs(edge) in graph.edges and graph.edge(edge) == known.edge(edge)
               and graph.start_vertex(edge) == known.start_vertex(edge)
               and graph.end_vertex(edge) == known.end_vertex(edge) for edge in route.edges)
