"""Drives one route: decides where to send the robot next, and what ends the route.

`Vehicle` keeps the phase of the route. This module completes edges, and ends the route, as follows:

    event                                                   what follows
    the location shows the end of the current edge          the edge is complete
    the robot reports its arrival there, and is near        the edge is complete
    the last edge is complete                               the route is COMPLETE
    the robot passes a vertex without coming near it        it is sent back, once
    it misses this vertex again, or rests far from its goal failed: NOT_ARRIVED
    two locations in a row outside the corridors            failed: OFF_GRAPH
    no progress for `stall_timeout`                         failed: NO_PROGRESS

Invariants: the robot is never sent back to an edge that is complete. No command is repeated while
the robot is on its way. Nothing is sent while it is unknown whether the robot obeys.
"""
from __future__ import annotations

import math
from typing import List, Optional, Tuple

from omron_ld90.bridge.goal_tracker import DOCK, GoalTracker, RouteFailed
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.robot_state import RobotLocation
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_strategies import RouteSettings, StrategyContext
from omron_map_converter.goal_names import goal_name
from route_protocol.values import Phase, Reason, ReasonCode
from route_protocol.vehicle import Vehicle
from trajectory_graph import Graph
from trajectory_graph.drawn_names import vertex_name

PROGRESS = 0.05  # m along the route that count as progress
LEAD = 2.0       # s from our command until the robot drives on a new path, including a reserve
RESTS_TO_JUDGE = 2  # locations at rest after a reported arrival; the first may be older than it


class RouteRun:
    """Drives the route that `vehicle` follows, or followed last.

    `locate` and `drive_on` raise RouteFailed if the route cannot go on. Indices of edges are
    indices in `progress.edges`, which are the edges of the order.

    The attributes are the state of one route: the target, the edges that the robot may be on, and
    the progress.
    """

    def __init__(self, vehicle: Vehicle, settings: RouteSettings, tracker: GoalTracker,
                 location: RobotLocation, progress: RouteProgress, now: float) -> None:
        self.progress = progress
        self.target: Optional[int] = None
        """Index of the edge to whose end the robot was sent."""
        self._vehicle = vehicle
        self._settings = settings
        self._tracker = tracker
        self._location = location
        self._sent_back: List[int] = []     # indices of vertices that the robot missed
        self._strayed = False               # whether the last location was off the corridor
        self._allowed: Tuple[int, Tuple[int, ...]] = (-1, ())
        self._best = -math.inf
        self._best_at = now
        self._count_edges()

    # --- progress --------------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """Whether the route is being driven."""
        return self._vehicle.state.is_running

    def _count_edges(self) -> None:
        """Reports to `Vehicle` which edges are complete."""
        self._vehicle.complete(self.progress.current)

    @property
    def edges_under_way(self) -> Tuple[int, ...]:
        """The edges on which the robot may brake: from the last complete edge to the edge after
        `target`.
        """
        current = self.progress.current
        return self.progress.edges[max(current - 1, 0):max(current, self.target or 0) + 2]

    def is_on(self, edge: int) -> bool:
        """Returns whether the robot is on this edge or just past it, or the route failed on it."""
        if self._vehicle.state.phase not in (Phase.RUNNING, Phase.FAILED):
            return False
        current = self.progress.current
        return edge in self.progress.edges[
            max(current - 1, 0) if self.running else current:current + 1]

    def decides_pose(self, here: GraphLocation) -> bool:
        """Returns whether the robot is driving the route, or is still at its end."""
        if self._vehicle.state.phase is not Phase.COMPLETE:
            return self.running
        end = self.progress.end(-1)
        if here.is_docked:
            return end.id == self._settings.dock_vertex
        return math.dist(here.position, end.position) <= self._settings.vertex_tolerance

    # --- driving ---------------------------------------------------------------------------------

    def allow(self, edges: Tuple[int, ...]) -> None:
        """Lets the robot brake on these `edges`, until the current edge is complete."""
        self._allowed = (self.progress.current, edges)

    def use_graph(self, graph: Graph) -> None:
        """Continues with another graph in which the route's edges are unchanged."""
        self.progress.graph = graph
        until, allowed = self._allowed
        self._allowed = (until, tuple(edge for edge in allowed if abs(edge) in graph.edges))

    def can_stop_within(self, edges: int, now: float) -> bool:
        """Returns whether the robot can stop within this number of edges; the current edge is the
        first of them.

        This is so if its target is on these edges, or if the end of the edges is far enough away.
        """
        last = self.progress.current + edges - 1
        if self.target is not None and self.target <= last:
            return True
        age = max(now - self._location.heard, 0.0)
        return self.progress.distance_to_end(last) >= self._braking_distance(age + LEAD)

    def replace(self, now: float) -> None:
        """Continues with the vehicle's new order, which has the same current edge."""
        self.allow(self.edges_under_way)
        state = self._vehicle.state
        current = state.done - state.first
        shift = current - self.progress.current
        self.progress.replace_edges(state.edges, current)
        self._sent_back = [index + shift for index in self._sent_back]
        self._allowed = (self._allowed[0] + shift, self._allowed[1])
        self._best = -math.inf
        if self.running:
            self.target = None
            self._best_at = now
            self.drive()

    def resume(self, target: int, number: int, now: float) -> None:
        """Continues after a restart. Before the restart, the robot was sent to the end of edge
        `target` by the command with this number.
        """
        self.target = target
        self._tracker.resume(self._goal_of(target), self._command_to(target), number, now)

    def drive(self) -> None:
        """Sends the robot to the target of the strategy, unless it is on its way there.

        If the robot missed a vertex, it is first sent back to this vertex, with any strategy.
        Nothing is sent while it is unknown whether the robot obeys the last command.
        """
        if self.progress.done or self._tracker.awaits_motion:
            return
        if self._tracker.goal is None:
            self.target = None
        target = self.progress.current
        if target not in self._sent_back:
            target = self._settings.strategy(StrategyContext(
                self.progress, self.target, self._tracker.reached, self._horizon(),
                self._settings.corridor_width))
        if target != self.target:
            self._send_to(target)

    def locate(self, here: GraphLocation, now: float) -> str:
        """Takes a location of the robot; returns a message for a person, or an empty text."""
        self.progress.move_to(*here.position)
        self._count_edges()
        self._check_corridor(here)
        if (self.target is not None and self.progress.current < self.target
                and self.progress.has_overshot() and not here.is_docked):
            return self._send_back(now)
        return ''

    def drive_on(self, now: float, docking_changed: float) -> str:
        """Accepts a reported arrival when the robot's location confirms it, and drives on.

        Also checks that the robot makes progress. Returns a message for a person, or an empty text.

        docking_changed -- when the docking state last changed; a change counts as progress
        """
        self._best_at = max(self._best_at, docking_changed)
        tracker = self._tracker
        if (tracker.reached and self.progress.current == self.target
                and (tracker.goal == DOCK
                     or self._distance_to_target() <= self._settings.vertex_tolerance)):
            self.progress.complete_current()
            self._count_edges()
        if self.progress.done:
            tracker.end()
            return ''
        self.drive()
        self._check_progress(now)
        if tracker.reached and tracker.rested_at_goal >= RESTS_TO_JUDGE:
            if self.target is not None and self.progress.current < self.target:
                return self._send_back(now)
            raise RouteFailed(Reason(
                ReasonCode.NOT_ARRIVED, f'the robot says that it is at {tracker.goal}, but is '
                                        f'{self._distance_to_target():.1f} m away from it'))
        return ''

    def _check_progress(self, now: float) -> None:
        if self.progress.travelled > self._best + PROGRESS:
            self._best = self.progress.travelled
            self._best_at = now
        if now - self._best_at > self._settings.stall_timeout:
            raise RouteFailed(Reason(ReasonCode.NO_PROGRESS,
                                     f'no progress for {self._settings.stall_timeout:.0f} s'))

    def _goal_of(self, index: int) -> str:
        vertex = self.progress.end(index)
        return DOCK if vertex.id == self._settings.dock_vertex else goal_name(vertex)

    def _send_to(self, index: int) -> None:
        self.target = index
        goal = self._goal_of(index)
        if goal == self._tracker.goal and not self._tracker.reached:
            return  # the robot is on its way there: no motion command is repeated
        self._tracker.send(goal, self._command_to(index))

    def _command_to(self, index: int) -> str:
        goal = self._goal_of(index)
        if goal == DOCK:
            return DOCK
        if self._settings.native_command:
            goals = [self._goal_of(i) for i in range(self.progress.current, index + 1)]
            return self._settings.native_command.format(goals=' '.join(goals), last=goal)
        return f'goto {goal}'

    def _send_back(self, now: float) -> str:
        """Sends the robot back to a vertex that it missed. Raises RouteFailed the second time."""
        current = self.progress.current
        name = vertex_name(self.progress.graph, self.progress.end(current).id)
        if current in self._sent_back:
            raise RouteFailed(Reason(
                ReasonCode.NOT_ARRIVED,
                f'the robot went by {name} without coming near it'))
        self._sent_back.append(current)
        self.allow(self.edges_under_way)
        self._best_at = now
        self._send_to(current)
        return f'The robot missed {name} and is sent back to it.'

    def _check_corridor(self, here: GraphLocation) -> None:
        """Fails the route if the robot is outside the corridors twice in a row."""
        edges = self.progress.edges[max(self.progress.current - 1, 0):
                                    max(self.progress.current, self.target or 0) + 1]
        until, allowed = self._allowed
        if self.progress.current <= until:
            edges += allowed
        strays = not here.is_about_the_dock and here.nearest_of(edges) is None
        if strays and self._strayed:
            raise RouteFailed(Reason(ReasonCode.OFF_GRAPH, 'off the corridor'))
        self._strayed = strays

    def _horizon(self) -> float:
        """Returns the distance (m) from a goal within which the robot may begin to brake before its
        next location comes.
        """
        return self._braking_distance(self._location.period + LEAD)

    def _braking_distance(self, seconds: float) -> float:
        """Returns the distance (m) that the robot drives until it stands if it brakes after
        `seconds`.
        """
        settings = self._settings
        speed = min(settings.top_speed, self._location.speed + settings.acceleration * seconds)
        return speed * speed / (2.0 * settings.braking) + speed * seconds

    def _distance_to_target(self) -> float:
        """Returns the distance to the target (m); infinite if location or target are unknown."""
        last = self._location.last
        if last is None or self.target is None:
            return math.inf
        return math.dist(last.position, self.progress.end(self.target).position)
