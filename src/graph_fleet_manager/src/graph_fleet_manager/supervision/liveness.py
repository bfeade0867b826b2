"""Whether a robot reports, moves and answers: what its reports tell by when they come."""
from __future__ import annotations

import math
from typing import Tuple

from graph_fleet_manager.interlocking.reports import TREMBLE, Pose, Report, distance
from trajectory_graph import Graph
from trajectory_graph.route_protocol import ANSWERED_WITHIN

SILENCE = 5.0      # s without a report after which a robot counts as silent
ANSWER = ANSWERED_WITHIN + 1.0  # s after which a robot that reports, but answers no order, is deaf
STANDING = 2.0     # s without motion after which a robot that lost its link is believed to stand


class Liveness:
    """One robot's signs of life; times are those of the supervisor's clock."""

    def __init__(self) -> None:
        self.seen = -math.inf
        """When it last reported; infinitely long ago: never."""
        self.since = -math.inf
        """Since when it reports without a silence."""
        self._stamp = 0.0
        self._pose = Pose()
        self._moved = -math.inf      # when it was last seen to move, or first seen: from _pose
        self._located = -math.inf    # when it last told of another location than before
        self._fresh_after = 0.0      # stamp, by its clock, of its location when its link was lost
        self._route: Tuple[int, Tuple[int, ...]] = (0, ())  # that it last reported
        self._is_running = False     # whether anything of that was still to be driven
        self._answered = -math.inf   # when it last had nothing to answer, or showed that it hears

    @property
    def is_seen(self) -> bool:
        """Has it reported since the fleet manager began?"""
        return self.seen > -math.inf

    def hear(self, report: Report, graph: Graph, now: float) -> None:
        """Notes when a report came, and what is new in it."""
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
        """Did it report before, but not for a while?"""
        return self.is_seen and now - self.seen > SILENCE

    def is_still(self, now: float) -> bool:
        """Does it report where it is now, and has it neither moved nor a route to drive?

        One that reports an old location may drive on meanwhile.
        """
        return (not self._is_running and now - self.seen <= STANDING
                and now - self._located < STANDING and now - self._moved >= STANDING)

    def stands_for(self, now: float) -> float:
        """s since when it was last seen to move, or first seen; 0: it does not report."""
        return now - self._moved if self.is_seen and not self.is_silent(now) else 0.0

    # -- answers to orders ------------------------------------------------------------------------

    def nothing_to_answer(self, now: float) -> None:
        """No order waits for its answer now."""
        self._answered = now

    def takes_up(self, report: Report, has_order: bool, now: float) -> bool:
        """Does a report tell of another route than the last, or is there no order to answer?

        A robot that took up an order, even an older one, is not deaf.
        """
        route = report.route_id, report.edges
        takes_up = not has_order or route != self._route
        self._route = route
        if takes_up:
            self._answered = now
        return takes_up

    def is_deaf(self, now: float) -> bool:
        """Has it not answered an order for a while?"""
        return now - self._answered > ANSWER

    # -- the link between the robot and its computer ----------------------------------------------

    def lose_link(self) -> None:
        """Its computer tells that the link to it was lost after the last location."""
        self._fresh_after = self._stamp

    def is_linked_again(self, report: Report, now: float) -> bool:
        """Do new locations come, and does it stand?

        The robot's clock need not be ours, and may be set meanwhile.
        """
        self._fresh_after = min(self._fresh_after, report.stamp)
        return report.stamp > self._fresh_after + STANDING and self.is_still(now)
