"""Finds the route that is driven, and the route to display, in the messages about routes.

No ROS here; times are in seconds of a steady clock.
"""
from __future__ import annotations

import math
from typing import NamedTuple, Optional, Sequence, Tuple

from route_protocol.values import EdgeState

SILENCE = 3.0  # s
SHOWN_AFTER_THE_END = 15.0  # s


class EdgeProgress(NamedTuple):
    """A signed edge of a route, and its state (a constant of EdgeState)."""

    edge: int
    state: int


class RouteWatch:
    """Finds out whether the fleet is driving the robot.

    A running route is reported ten times a second. A route without a report for `SILENCE` s is
    over: the bridge has ended, or its connection to this computer is broken.
    """

    def __init__(self) -> None:
        self._running: Optional[int] = None
        self._heard = -math.inf

    def update(self, route_id: int, states: Sequence[int], now: float) -> bool:
        """Takes the states of all edges of a route. Returns False if they only show that a route
        was refused while another route runs.
        """
        failed = any(state == EdgeState.FAILED for state in states)
        if not failed and any(state != EdgeState.COMPLETE for state in states):
            self._running, self._heard = route_id, now
        elif failed and self.running(now) not in (None, route_id):
            return False
        else:
            self._running = None
        return True

    def running(self, now: float) -> Optional[int]:
        """Returns the id of the route being driven at `now`, or None."""
        return self._running if now - self._heard <= SILENCE else None


class RouteView:
    """The route on display: the route that is driven or, for some time after its end, the last."""

    def __init__(self) -> None:
        self.shown: Tuple[EdgeProgress, ...] = ()
        self._watch = RouteWatch()
        self._last: Tuple[Optional[int], Tuple[EdgeProgress, ...]] = (None, ())
        self._changed = -math.inf

    def update(self, route_id: int, edges: Sequence[EdgeProgress], now: float) -> bool:
        """Takes a message. Returns whether the displayed route changed."""
        route = (route_id, tuple(edges))
        if not self._watch.update(route_id, [edge.state for edge in edges], now):
            return False
        if route == self._last:
            return False
        self._last, self._changed = route, now
        self.shown = route[1]
        return True

    def expire(self, now: float) -> bool:
        """Removes a route that ended SHOWN_AFTER_THE_END s ago. Returns whether it did so now."""
        ended = self._watch.running(now) is None
        if not (self.shown and ended and now - self._changed >= SHOWN_AFTER_THE_END):
            return False
        self.shown = ()
        return True
