"""The strategies: where to send the robot, and when, so that it drives a route's edges in order.

A strategy gets the progress and the vertex to which the robot was last sent. It returns the index
of the edge to whose end the robot should drive. The strategies differ in how far ahead they look,
and in when they send the next goal:
| strategy           | looks ahead                                      | sends the next goal     |
|--------------------|--------------------------------------------------|-------------------------|
| `vertex_by_vertex` | one vertex                                       | once the robot stops    |
| `direct`           | as far as the robot's own path follows the route | once the robot stops    |
| `rolling`          | as `direct`, but only as far as braking requires | before the robot brakes |
| `native`           | to the next dock or the end, naming every vertex | once the robot stops    |
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Mapping, Optional

from omron_ld90 import robot_model
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.shortest_paths import follows_on

LONGEST_PIECE = 100.0  # m: on large graphs, looking farther ahead takes too long


@dataclass(frozen=True)
class StrategyContext:
    """The input of a strategy."""

    progress: RouteProgress
    target: Optional[int]  # index of the edge to whose end the robot was sent; None: nowhere
    arrived: bool          # whether the robot has stopped there
    horizon: float         # m: if the target is nearer, the robot may brake before it reports again
    corridor_width: float  # m

    @property
    def target_is_behind(self) -> bool:
        """Whether there is no target ahead: none was sent, or the robot has passed it."""
        return self.target is None or self.progress.current > self.target

    def farthest_free(self, first: int, wanted: Callable[[int], bool]) -> int:
        """Returns the index of the farthest edge to whose end the robot's path follows the route.

        The search begins with the edge `first`. It goes beyond an edge only if the index of the
        edge is `wanted`, and never beyond the next stop.
        """
        progress, index = self.progress, first
        while (index < progress.next_stop and wanted(index) and follows_on(
                progress.graph, progress.edges[progress.current:index + 2], progress.arc,
                self.corridor_width, progress.tolerance)):
            index += 1
        return index


Strategy = Callable[[StrategyContext], int]
"""Returns the index of the target edge. If it is the present target, nothing is sent."""


def vertex_by_vertex(context: StrategyContext) -> int:
    """Sends one goto per vertex, so that the robot stops at each vertex."""
    if context.target is None or (context.target_is_behind and context.arrived):
        return context.progress.current
    return context.target


def direct(context: StrategyContext) -> int:
    """Sends one goal for each piece on which the robot's own path follows the route."""
    if context.target is None or (context.target_is_behind and context.arrived):
        return context.farthest_free(
            context.progress.current,
            lambda index: context.progress.distance_to_end(index) < LONGEST_PIECE)
    return context.target


def rolling(context: StrategyContext) -> int:
    """Sends the next goal before the robot brakes, if the path to it passes the present goal."""
    progress = context.progress
    first = (progress.current if context.target is None or context.target_is_behind
             else context.target)
    return context.farthest_free(
        first, lambda index: progress.distance_to_end(index) <= context.horizon)


def native(context: StrategyContext) -> int:
    """Sends the last vertex; the command names the vertices on the way."""
    return context.progress.next_stop


STRATEGIES: Mapping[str, Strategy] = {
    'vertex_by_vertex': vertex_by_vertex,
    'direct': direct,
    'rolling': rolling,
    'native': native,
}


@dataclass(frozen=True)
class RouteSettings:
    """The settings for driving routes, in m and s.

    The default motion values are those of the LD-90. Each attribute is a parameter of the node.
    """

    dock_vertex: Optional[int] = None
    strategy: Strategy = rolling
    native_command: str = ''  # template that replaces `goto`, with {goals} or {last}
    vertex_tolerance: float = 0.3
    corridor_width: float = 0.9
    stall_timeout: float = 30.0
    location_timeout: float = 5.0
    link_timeout: float = 2.0
    restart_timeout: float = 20.0
    top_speed: float = robot_model.TOP_SPEED
    acceleration: float = robot_model.ACCELERATION
    braking: float = robot_model.BRAKING_TO_GOAL
