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

from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_ways import follows_on

LONGEST_PIECE = 100.0  # m: to look farther ahead takes long on large graphs


@dataclass(frozen=True)
class Outlook:
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


Strategy = Callable[[Outlook], int]
"""Answers with the index of the target edge; the same as before means: send nothing."""


def vertex_by_vertex(outlook: Outlook) -> int:
    """A goto per vertex; the robot stops at each."""
    if outlook.target is None or (outlook.target_is_behind and outlook.arrived):
        return outlook.progress.current
    return outlook.target


def direct(outlook: Outlook) -> int:
    """As few goals as possible: one for each piece of the route that the robot drives freely."""
    if outlook.target is None or (outlook.target_is_behind and outlook.arrived):
        return outlook.farthest_free(
            outlook.progress.current,
            lambda index: outlook.progress.distance_to_end(index) < LONGEST_PIECE)
    return outlook.target


def rolling(outlook: Outlook) -> int:
    """The next goal before the robot brakes for this one, where it will still pass this one."""
    progress = outlook.progress
    first = progress.current if outlook.target_is_behind else outlook.target
    return outlook.farthest_free(
        first, lambda index: progress.distance_to_end(index) <= outlook.horizon)


def native(outlook: Outlook) -> int:
    """The last vertex; the command names those on the way."""
    return outlook.progress.next_stop


STRATEGIES: Mapping[str, Strategy] = {
    'vertex_by_vertex': vertex_by_vertex,
    'direct': direct,
    'rolling': rolling,
    'native': native,
}
