"""When to send the robot where, so that it drives the edges of a route in order.

A strategy looks at the progress and at the vertex that the robot was last sent to, and answers with
the index of the edge to whose end the robot should be heading. They differ in how far ahead they
look and in what they wait for:

| strategy           | looks ahead                                      | goes on                 |
|--------------------|--------------------------------------------------|-------------------------|
| `vertex_by_vertex` | one vertex                                       | once the robot stops    |
| `direct`           | as far as the robot's free way is the route      | once the robot stops    |
| `rolling`          | the same, but no farther than braking demands    | before the robot brakes |
| `native`           | to the next dock or the end, naming every vertex | once the robot stops    |
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Mapping, Optional

from omron_ld90 import robot_model
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.shortest_paths import follows_on

LONGEST_PIECE = 100.0  # m: to look farther ahead takes long on large graphs


@dataclass(frozen=True)
class StrategyContext:
    """What a strategy decides from."""

    progress: RouteProgress
    target: Optional[int]  # index of the edge to whose end the robot was sent; None: nowhere
    arrived: bool          # the robot has stopped there
    horizon: float         # m: a target nearer than this makes the robot brake before we look again
    corridor_width: float  # m

    @property
    def target_is_behind(self) -> bool:
        """Whether there is no target any more: none was sent, or its vertex has been passed."""
        return self.target is None or self.progress.current > self.target

    def farthest_free(self, first: int, wanted: Callable[[int], bool]) -> int:
        """The last index from `first` on to which the robot, sent there, would drive the route.

        It goes on from an index that it `wanted` to go on from, and never beyond the next stop.
        """
        progress, index = self.progress, first
        while (index < progress.next_stop and wanted(index) and follows_on(
                progress.graph, progress.edges[progress.current:index + 2], progress.arc,
                self.corridor_width, progress.tolerance)):
            index += 1
        return index


Strategy = Callable[[StrategyContext], int]
"""Answers with the index of the target edge; the same as before means: send nothing."""


def vertex_by_vertex(context: StrategyContext) -> int:
    """A goto per vertex; the robot stops at each."""
    if context.target is None or (context.target_is_behind and context.arrived):
        return context.progress.current
    return context.target


def direct(context: StrategyContext) -> int:
    """As few goals as possible: one for each piece of the route that the robot drives freely."""
    if context.target is None or (context.target_is_behind and context.arrived):
        return context.farthest_free(
            context.progress.current,
            lambda index: context.progress.distance_to_end(index) < LONGEST_PIECE)
    return context.target


def rolling(context: StrategyContext) -> int:
    """The next goal before the robot brakes for this one, where it will still pass this one."""
    progress = context.progress
    first = (progress.current if context.target is None or context.target_is_behind
             else context.target)
    return context.farthest_free(
        first, lambda index: progress.distance_to_end(index) <= context.horizon)


def native(context: StrategyContext) -> int:
    """The last vertex; the command names those on the way."""
    return context.progress.next_stop


STRATEGIES: Mapping[str, Strategy] = {
    'vertex_by_vertex': vertex_by_vertex,
    'direct': direct,
    'rolling': rolling,
    'native': native,
}


@dataclass(frozen=True)
class Settings:
    """What a user can set about the driving of routes. m and s; the motion is the LD-90's."""

    dock_vertex: Optional[int] = None
    strategy: Strategy = rolling
    native_command: str = ''  # in place of `goto`, with {goals} and {last}
    vertex_tolerance: float = 0.3
    corridor_width: float = 0.9
    stall_timeout: float = 30.0
    location_timeout: float = 5.0
    link_timeout: float = 2.0
    restart_timeout: float = 20.0
    top_speed: float = robot_model.TOP_SPEED
    acceleration: float = robot_model.ACCELERATION
    braking: float = robot_model.BRAKING_TO_GOAL
