"""The last location of the robot, and the state of its links and of the nodes that watch them.

Times are in seconds of a monotonic clock, stamps in nanoseconds of ROS time, lengths in m.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterable, Optional, Tuple

from omron_ld90.bridge.events import LinkReported, RobotLink
from route_protocol.values import NO_REASON, Reason, ReasonCode

NANOSECONDS = 1e-9
CLOCK_SET_BACK = 5_000_000_000  # ns: if a stamp is older by more than this, the clock was set back
USUAL_PERIOD = 0.5              # s between two statuses of the robot, until the period is measured
NODE_SILENCE = 2.0              # s without a report after which a node counts as away; 1 s is usual


@dataclass(frozen=True)
class MapLocation:
    """A location (m, map frame) that the robot reported; `heading` is None if it reported none."""

    stamp: int
    x: float
    y: float
    heading: Optional[float] = None

    @property
    def position(self) -> Tuple[float, float]:
        """x and y."""
        return self.x, self.y


class RobotLocation:
    """The last location, the speed of the robot, and the period of its locations."""

    def __init__(self) -> None:
        self.last: Optional[MapLocation] = None
        self.heard = -math.inf
        """When the last location came, s."""
        self.speed = 0.0
        """Speed between the last two locations, m/s."""
        self.period = USUAL_PERIOD
        """Time between the last two locations, s."""

    def update(self, location: MapLocation, now: float) -> bool:
        """Takes a location. Ignores a location that came late or twice, and then returns False."""
        if self.last is not None:
            step = location.stamp - self.last.stamp
            if -CLOCK_SET_BACK < step <= 0:
                return False
            if step > 0:
                seconds = step * NANOSECONDS
                self.speed = math.dist(location.position, self.last.position) / seconds
                self.period = min(seconds, 2.0 * USUAL_PERIOD)
        self.last = location
        self.heard = now
        return True


class _LinkState:
    """One link, and the node that reports about it."""

    def __init__(self) -> None:
        self.up = False
        self.reason = ''
        self.heard: Optional[float] = None   # time of the last report
        self.changed = -math.inf             # when the link last went up or down
        self.spared_until = -math.inf        # until then the link may be down, as its node was away

    def update(self, report: LinkReported, now: float, restart_timeout: float) -> None:
        if self.heard is not None and now - self.heard > NODE_SILENCE:
            self.spared_until = self.heard + restart_timeout
            self.changed = now
        if self.heard is None or report.up != self.up:
            self.changed = now
        self.up, self.reason, self.heard = report.up, report.reason, now

    def node_is_away(self, now: float) -> bool:
        return self.heard is not None and now - self.heard > NODE_SILENCE


class RobotLinks:
    """The links to the robot.

    A link that its node reports as down counts as lost after `link_timeout` (s). If a node stops
    reporting, it is being restarted or is suspended. Then its link counts as lost only if it is not
    up `restart_timeout` (s) after the last report.
    """

    def __init__(self, expected: Iterable[RobotLink], link_timeout: float,
                 restart_timeout: float) -> None:
        self._links: Dict[RobotLink, _LinkState] = {link: _LinkState() for link in expected}
        self._link_timeout = link_timeout
        self._restart_timeout = restart_timeout

    @property
    def are_expected(self) -> bool:
        """Whether at least one link must be up to drive the robot."""
        return bool(self._links)

    def update(self, report: LinkReported, now: float) -> None:
        """Takes a report about a link from the node that watches it."""
        if report.link in self._links:
            self._links[report.link].update(report, now, self._restart_timeout)

    def stands(self, link: RobotLink, now: float) -> bool:
        """Returns whether the link is up and its node reports.

        True for a link that is not expected.
        """
        state = self._links.get(link)
        return state is None or (state.up and not state.node_is_away(now))

    def up_since(self, link: RobotLink) -> float:
        """Returns when the link last changed, or its node came back.

        -inf for a link that is not expected.
        """
        state = self._links.get(link)
        return -math.inf if state is None else state.changed

    def why_unusable(self, now: float) -> Reason:
        """Returns the reason why the links do not allow driving now; empty if they do."""
        for link, state in self._links.items():
            if state.heard is None:
                return Reason(ReasonCode.NOT_READY,
                              f'no report has arrived about the link {link.value}')
            if state.node_is_away(now) and state.up:
                return _node_is_away(link, now - state.heard)
            if not state.up:
                return _lost(link, state.reason)
        return NO_REASON

    def why_lost(self, now: float) -> Reason:
        """Returns the reason why a link counts as lost; empty if no link does."""
        for link, state in self._links.items():
            if state.heard is None:
                continue
            away = now - state.heard
            if state.node_is_away(now):
                if away > self._restart_timeout:
                    return _node_is_away(link, away)
            elif not state.up and now > max(state.changed + self._link_timeout,
                                            state.spared_until):
                return _lost(link, state.reason)
        return NO_REASON


def _node_is_away(link: RobotLink, seconds: float) -> Reason:
    return _lost(link, f'its node has reported nothing for {seconds:.0f} s')


def _lost(link: RobotLink, why: str) -> Reason:
    return Reason(ReasonCode.LOST_LINK, f'lost link: {link.value}: {why}')
