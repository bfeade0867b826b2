"""What the robot does, as the reports to the fleet manager say it.

    | a route runs | its link | another giver drives it | it rests    | what it does               |
    |--------------|----------|-------------------------|-------------|----------------------------|
    | yes          |          |                         |             | ON_ROUTE                   |
    | no           |          | yes                     |             | MOVED                      |
    | no           | down     | no                      |             | COMING_TO_REST after a     |
    |              |          |                         |             | lost route, else UNKNOWN   |
    | no           | up       | no                      | yes         | STANDING                   |
    | no           | up       | no                      | not yet     | COMING_TO_REST after a     |
    |              |          |                         |             | lost route, else MOVED     |

It rests when its locations have stayed within 5 cm for a second. A robot that has driven its route
to the end rests at once, because it said that it arrived.
"""
from __future__ import annotations

import math
from typing import Optional, Tuple

from omron_ld90.bridge.events import Motion as Seen
from route_protocol.values import Motion

NEAR = 0.05  # m by which the location of a standing robot may change
RESTS = 1.0  # s near one place after which the robot rests

_DRIVING = (Seen.GOING, Seen.DOCKING, Seen.UNDOCKING, Seen.BY_HAND, Seen.STOPPING)


class MotionJudge:
    """Knows whether the robot rests, and whether it may still roll on from a lost route."""

    def __init__(self) -> None:
        self.is_foreign = False
        """Does another giver drive the robot, by its last motion?"""
        self._has_lost_route = False
        self._place: Optional[Tuple[float, float]] = None
        self._since = math.inf  # when it came near that place

    def route_lost(self) -> None:
        """The route failed or was stopped: the robot may roll on until it rests."""
        self._has_lost_route = True
        self._place = None

    def route_begins(self) -> None:
        """The robot drives a route of the fleet manager again."""
        self._has_lost_route = self.is_foreign = False

    def arrived(self) -> None:
        """The robot has said that it arrived at the end of its route."""
        self._has_lost_route = False
        self._place, self._since = None, -math.inf

    def located(self, place: Tuple[float, float], now: float) -> None:
        """The robot was located at x, y (m)."""
        if self._place is None or math.dist(place, self._place) > NEAR:
            rests_at_once = self._place is None and self._since == -math.inf
            self._place, self._since = place, -math.inf if rests_at_once else now
        if self.rests(now):
            self._has_lost_route = False

    def rests(self, now: float) -> bool:
        """Has the robot stayed near one place?"""
        return self._place is not None and now - self._since >= RESTS

    def motion(self, is_running: bool, is_linked: bool, seen: Optional[Seen],
               now: float) -> Motion:
        """What the robot does at `now` (s)."""
        if is_running:
            return Motion.ON_ROUTE
        if self.is_foreign and (seen in _DRIVING or not self.rests(now)):
            return Motion.MOVED
        if is_linked and self._place is not None and self.rests(now):
            return Motion.STANDING
        if self._has_lost_route:
            return Motion.COMING_TO_REST
        return Motion.MOVED if is_linked and self._place is not None else Motion.UNKNOWN
