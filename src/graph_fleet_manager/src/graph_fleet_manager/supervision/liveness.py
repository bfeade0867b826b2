"""Liveness of one robot: whether it reports, moves and answers, judged by when reports come."""
from __future__ import annotations

import math
from typing import Tuple

from graph_fleet_manager.interlocking.reports import TREMBLE, Pose, Report, distance
from route_protocol.values import ANSWERED_WITHIN
from trajectory_graph import Graph

SILENCE = 5.0      # s without a report after which a robot counts as silent
# s after which a robot that reports, but has not answered an order, counts as deaf
ANSWER = ANSWERED_WITHIN + 1.0
# s without motion after which a robot that lost its link is assumed to stand
STANDING = 2.0


class Liveness:
    """The signs of life of one robot. Times are those of the supervisor's clock."""

    def __init__(self) -> None:
        self.seen = -math.inf
        """Time of its last report; minus infinity: never."""
        self.since = -math.inf
        """Time since which it has reported without a silence."""
        self._stamp = 0.0
        self._pose = Pose()
        self._moved = -math.inf      # when it was last seen to move from _pose, or first seen
        self._located = -math.inf    # when it last reported another location than before
        self._fresh_after = 0.0      # stamp, by its clock, of its location when its link was lost
        self._route: Tuple[int, Tuple[int, ...]] = (0, ())  # the route that it last reported
        self._is_running = False     # whether any of that route was still to be driven
        self._answered = -math.inf   # when it last had no order to answer, or took one up

    @property
    def is_seen(self) -> bool:
        """Has the robot reported since the fleet manager began?"""
        return self.seen > -math.inf

    def hear(self, report: Report, graph: Graph, now: float) -> None:
        """Notes when a report came, and what has changed in it."""
        if not self.is_seen:
            self._answered = now
        if now - self.seen > SILENCE:
            self.since = now
        self.seen = now
        if distance(graph, report.pose, self._pose) > TREMBLE:
            self._pose, self._moved = report.pose, now
        if report.stamp != self._stamp or not report.stamp:
            self._located = now
        self._stamp = report.stamp
        self._is_running = report.is_running

    def is_silent(self, now: float) -> bool:
        """Has the robot reported before, but not for SILENCE s?"""
        return self.is_seen and now - self.seen > SILENCE

    def is_still(self, now: float) -> bool:
        """Does the robot report current locations, has it nothing to drive, and does it not move?

        A robot that reports an old location may drive on meanwhile.
        """
        return (not self._is_running and now - self.seen <= STANDING
                and now - self._located < STANDING and now - self._moved >= STANDING)

    def stands_for(self, now: float) -> float:
        """s since it was last seen to move, or first seen; 0: it does not report."""
        return now - self._moved if self.is_seen and not self.is_silent(now) else 0.0

    # -- answers to orders ------------------------------------------------------------------------

    def nothing_to_answer(self, now: float) -> None:
        """No order waits for an answer now."""
        self._answered = now

    def takes_up(self, report: Report, has_order: bool, now: float) -> bool:
        """Has the reported route changed, or is there no order to answer?

        A robot that took up an order, even an older one, is not deaf.
        """
        route = report.route_id, report.edges
        takes_up = not has_order or route != self._route
        self._route = route
        if takes_up:
            self._answered = now
        return takes_up

    def is_deaf(self, now: float) -> bool:
        """Has the robot not answered an order for ANSWER s?"""
        return now - self._answered > ANSWER

    # -- the link between the robot and its computer ----------------------------------------------

    def lose_link(self) -> None:
        """The robot's computer reports that it lost the link after the last location."""
        self._fresh_after = self._stamp

    def is_linked_again(self, report: Report, now: float) -> bool:
        """Do new locations arrive, and does the robot stand?

        The robot's clock may differ from ours, and may be set meanwhile.
        """
        self._fresh_after = min(self._fresh_after, report.stamp)
        return report.stamp > self._fresh_after + STANDING and self.is_still(now)
