"""Continues a route that was running at a restart of the bridge; the robot may have driven on."""
from __future__ import annotations

from typing import Callable, Optional, Tuple

from omron_ld90.bridge.events import Motion, RobotSeen, RouteRecord
from omron_ld90.bridge.goal_tracker import RouteFailed, TakenOver
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.own_goals import DOCK
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_run import RouteRun
from omron_ld90.goal_names import goal_name
from route_protocol.order_rules import wrong_route
from route_protocol.values import Reason, ReasonCode
from trajectory_graph import Graph, TrajectoryGraphError, check_route


def go_on(route: RouteRun, record: RouteRecord, here: GraphLocation,
          progress: Callable[[Tuple[int, ...], int], RouteProgress], seen: RobotSeen,
          now: float) -> str:
    """Continues the route of `record`; returns a message for a person, or an empty text.

    `progress` makes the progress along edges from the current one on. If the route had ended, only
    the position on it is restored. Raises RouteFailed if a running route cannot continue.
    """
    try:
        check_route(here.graph, record.edges)
    except TrajectoryGraphError as error:
        if route.running:
            raise RouteFailed(wrong_route(error).reason) from None
        return ''
    if not route.running:
        route.progress = progress(record.edges, record.completed)
        return ''
    route.progress = progress(record.edges, _current_edge(record, here, seen))
    _resume(route, record, here.graph, seen, now)
    return f'Route {record.route_id} goes on after a restart of the bridge.'


def _current_edge(record: RouteRecord, here: GraphLocation, seen: RobotSeen) -> int:
    """Index of the edge on which the robot is; raises RouteFailed if the robot is elsewhere.

    If the robot is on the edges that lead to its last goal, the edges before that were driven.
    """
    last = record.completed if record.target is None else record.target
    ahead = record.edges[record.completed:last + 1]
    if not ahead or here.is_about_the_dock:
        return record.completed
    found = here.nearest_of(ahead)
    if found is not None:
        return record.completed + found
    if seen.motion is Motion.BY_HAND or (
            seen.motion is Motion.GOING and seen.goal != record.goal):
        raise TakenOver('While the bridge was restarted, another giver drove the robot elsewhere.')
    raise RouteFailed(Reason(
        ReasonCode.RESTARTED,
        'the robot was not on the route any more after a restart of the bridge'))


def _resume(route: RouteRun, record: RouteRecord, graph: Graph, seen: RobotSeen,
           now: float) -> None:
    """Continues a route whose progress is set; first checks where the robot is driving to."""
    current = route.completed
    if current >= len(record.edges):
        return
    target = _target_shown(graph, record, current, seen)
    if target is None:
        target = record.target
    if target is None or _rests_at_start(graph, record, current, seen):
        route.drive()
    else:
        route.resume(target, now)


def _target_shown(graph: Graph, record: RouteRecord, current: int,
                  seen: RobotSeen) -> Optional[int]:
    """Index of the edge to whose end the robot says that it drives; None if that is not ahead."""
    if seen.motion not in (Motion.GOING, Motion.ARRIVED):
        return None
    return next((index for index in range(current, len(record.edges))
                 if goal_name(graph.end_vertex(record.edges[index])) == seen.goal), None)


def _rests_at_start(graph: Graph, record: RouteRecord, current: int, seen: RobotSeen) -> bool:
    """Whether the robot stands at the start of the current edge, and was not sent on from there."""
    start = goal_name(graph.start_vertex(record.edges[current]))
    return (seen.motion is Motion.ARRIVED and seen.goal == start
            ) or (seen.motion is Motion.DOCKED and record.goal != DOCK)
