"""Continues a route that was running at a restart of the bridge; the robot may have driven on."""
from __future__ import annotations

from typing import Callable, Optional

from omron_ld90.bridge.events import Motion, RobotSeen, RouteRecord
from omron_ld90.bridge.goal_tracker import RouteFailed, TakenOver
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.own_goals import DOCK
from omron_ld90.bridge.route_orders import check_edges
from omron_ld90.bridge.route_run import RouteRun
from omron_ld90.goal_names import goal_name
from route_protocol.order_rules import RouteRefused
from route_protocol.values import Reason, ReasonCode
from trajectory_graph import Graph


def go_on(record: RouteRecord, here: GraphLocation, run: Callable[[int], RouteRun],
          seen: RobotSeen, now: float) -> Optional[RouteRun]:
    """Returns the route of `record`, continued; None if it had ended on another graph.

    `run` makes the route, with the index of the current edge. If the route had ended, only the
    position on it is restored. Raises RouteFailed if a running route cannot continue.
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
    current = _current_edge(record, here, seen)
    route = run(current)
    _resume(route, record, current, here.graph, seen, now)
    return route


def _current_edge(record: RouteRecord, here: GraphLocation, seen: RobotSeen) -> int:
    """Index of the edge on which the robot is; raises RouteFailed if the robot is elsewhere.

    If the robot is on the edges that lead to its last goal, the edges before that were driven.
    """
    completed = record.vehicle.completed
    last = completed if record.target is None else record.target
    ahead = record.vehicle.edges[completed:last + 1]
    if not ahead or here.is_about_the_dock:
        return completed
    found = here.nearest_of(ahead)
    if found is not None:
        return completed + found
    if seen.motion is Motion.BY_HAND or (
            seen.motion is Motion.GOING and seen.goal != record.goal):
        raise TakenOver('While the bridge was restarted, another giver drove the robot elsewhere.')
    raise RouteFailed(Reason(
        ReasonCode.RESTARTED,
        'the robot was not on the route any more after a restart of the bridge'))


def _resume(route: RouteRun, record: RouteRecord, current: int, graph: Graph, seen: RobotSeen,
            now: float) -> None:
    """Continues a route; first checks where the robot is driving to."""
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
    return next((index for index in range(current, len(record.vehicle.edges))
                 if goal_name(graph.end_vertex(record.vehicle.edges[index])) == seen.goal), None)


def _rests_at_start(graph: Graph, record: RouteRecord, current: int, seen: RobotSeen) -> bool:
    """Whether the robot stands at the start of the current edge, and was not sent on from there."""
    start = goal_name(graph.start_vertex(record.vehicle.edges[current]))
    return (seen.motion is Motion.ARRIVED and seen.goal == start
            ) or (seen.motion is Motion.DOCKED and record.goal != DOCK)
