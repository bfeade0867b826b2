"""Liveness of one robot: whether it reports, moves and answers orders."""
from __future__ import annotations

import math

from fleet_core.interlocking.reports import TREMBLE, Pose, Report, distance
from route_protocol.values import ANSWERED_WITHIN, Motion
from trajectory_graph import Graph

SILENCE = 5.0      # s without a report after which a robot counts as silent
# s: a robot that reports, but does not answer an order for this time, counts as deaf
ANSWER = ANSWERED_WITHIN + 1.0


class Liveness:
    """The signs of life of one robot. Times are those of the supervisor's clock."""

    def __init__(self) -> None:
        self.seen = -math.inf
        """Time of its last report; minus infinity: never."""
        self.since = -math.inf
        """Begin of the time in which it has reported without a silence."""
        self.stands = False
        """Whether the last report says that the robot stands."""
        self._pose = Pose()
        self._moved = -math.inf      # when it was last seen to move (to _pose), or was first seen
        self._answered = -math.inf   # when it last had no order to answer, or answered one

    @property
    def is_seen(self) -> bool:
        """Whether the robot has reported since the fleet manager began."""
        return self.seen > -math.inf

    def hear(self, report: Report, graph: Graph, now: float) -> None:
        """Notes that a report came at `now`, and whether the robot has moved or stands."""
        if not self.is_seen:
            self._answered = now
        if now - self.seen > SILENCE:
            self.since = now
        self.seen = now
        if distance(graph, report.pose, self._pose) > TREMBLE:
            self._pose, self._moved = report.pose, now
        self.stands = report.motion is Motion.STANDING

    def is_silent(self, now: float) -> bool:
        """Returns whether the robot has reported before, but not in the last SILENCE s."""
        return self.is_seen and now - self.seen > SILENCE

    def stands_for(self, now: float) -> float:
        """Returns the seconds since the robot was last seen to move, or was first seen.

        0: it does not report.
        """
        return now - self._moved if self.is_seen and not self.is_silent(now) else 0.0

    def nothing_to_answer(self, now: float) -> None:
        """Notes that no order waits for an answer now."""
        self._answered = now

    def is_deaf(self, now: float) -> bool:
        """Returns whether the robot has not answered an order for ANSWER s."""
        return now - self._answered > ANSWER
