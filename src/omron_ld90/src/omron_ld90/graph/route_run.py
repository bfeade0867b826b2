"""A route that was accepted, and what became of it."""
from __future__ import annotations

import math
from enum import Enum
from typing import List, Optional, Tuple

from omron_ld90.graph.route_progress import RouteProgress
from omron_ld90.graph.route_protocol import EdgeState, RouteOrder, RouteRecord

PROGRESS = 0.05  # m along the route that count as progress


class Phase(Enum):
    """What became of a route."""

    RUNNING = 'running'
    COMPLETE = 'complete'
    FAILED = 'failed'
    STOPPED = 'stopped'


class RouteRun:
    """A route, how far it is driven, and where the robot was sent for it."""

    def __init__(self, order: RouteOrder, progress: Optional[RouteProgress], now: float) -> None:
        """`progress` is None for an empty route."""
        self.order = order
        self.progress = progress
        self.phase = Phase.STOPPED if progress is None else Phase.RUNNING
        self.reason = ''
        self.target: Optional[int] = None
        """Index of the edge to whose end the robot was sent; None before it was sent anywhere."""
        self.arrived_at = -math.inf
        """When the robot said that it had reached the target."""
        self.sent_back: List[int] = []
        """Indices of vertices that the robot missed and was sent back to."""
        self.strayed = False
        """Whether the last location was off the corridor."""
        self._allowed: Tuple[int, Tuple[int, ...]] = (-1, ())
        self._best = -math.inf
        self._best_at = now

    @property
    def running(self) -> bool:
        """Whether the route is being driven."""
        return self.phase is Phase.RUNNING

    @property
    def edges(self) -> Tuple[int, ...]:
        """Signed ids, as ordered."""
        return self.order.edges

    @property
    def states(self) -> Tuple[EdgeState, ...]:
        """One state per edge."""
        if self.progress is None:
            return ()
        done = self.progress.current
        rest = EdgeState.FAILED if self.phase is Phase.FAILED else EdgeState.PROCESSING
        return (EdgeState.COMPLETE,) * done + (rest,) * (len(self.edges) - done)

    @property
    def record(self) -> Optional[RouteRecord]:
        """What a restarted bridge needs to go on; None where there is nothing to go on with."""
        if self.progress is None or self.phase is Phase.FAILED:
            return None
        current = self.progress.current
        return RouteRecord(self.order.route_id, self.edges, current,
                           current if self.target is None else max(current, self.target))

    def allow(self, edges: Tuple[int, ...]) -> None:
        """The robot was under way along `edges` when the route changed, and brakes on them."""
        self._allowed = (self.progress.current, edges)

    @property
    def leeway(self) -> Tuple[int, ...]:
        """Edges not of this route that the robot may still be on, until it has done the first."""
        current, edges = self._allowed
        return edges if self.progress.current <= current else ()

    def going_back(self) -> bool:
        """Whether the robot is on its way back to a vertex that it missed."""
        return self.progress.current in self.sent_back

    def seconds_without_progress(self, now: float) -> float:
        """Seconds since the robot last got farther along the route."""
        if self.progress.travelled > self._best + PROGRESS:
            self._best = self.progress.travelled
            self._best_at = now
        return now - self._best_at

    def count_as_progress(self, now: float) -> None:
        """Something moved on that is no way along the route, such as docking."""
        self._best_at = now
