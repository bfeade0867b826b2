"""What is known of the robot: where it was last seen, and how its links and their nodes stand.

Times are seconds of a monotonic clock, stamps nanoseconds of ROS time, lengths metres.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterable, Optional, Tuple

from omron_ld90.bridge.events import Link, LinkReported
from trajectory_graph.route_protocol import NO_REASON, Reason, ReasonCode

NANOSECONDS = 1e-9
CLOCK_SET_BACK = 5_000_000_000  # ns: an older stamp than the last by more than this is no late one
USUAL_PERIOD = 0.5              # s, of the robot's status, until it has been seen
NODE_SILENCE = 2.0              # s without a report, which comes every second: the node is away


@dataclass(frozen=True)
class Located:
    """A place (m, map frame) that the robot reported; `heading` is NaN where it told none."""

    stamp: int
    x: float
    y: float
    heading: float = math.nan

    @property
    def position(self) -> Tuple[float, float]:
        """x and y."""
        return self.x, self.y


class RobotLocation:
    """The last location, how fast the robot goes, and how often it tells."""

    def __init__(self) -> None:
        self.last: Optional[Located] = None
        self.heard = -math.inf
        """When the last location came."""
        self.speed = 0.0
        """m/s between the last two locations."""
        self.period = USUAL_PERIOD
        """Seconds between the last two locations."""

    def update(self, location: Located, now: float) -> bool:
        """Takes a location; False for one that comes late or twice, which is left out."""
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
    """One link, and the node that reports on it."""

    def __init__(self) -> None:
        self.up = False
        self.reason = ''
        self.heard: Optional[float] = None   # the last report
        self.changed = -math.inf             # it went up or down
        self.spared_until = -math.inf        # its node was away: so long the link may be down

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

    A link that its node reports as down is lost after `link_timeout` (s). A node that no longer
    reports is being restarted or stands still: it, and its link after it, get `restart_timeout`.
    """

    def __init__(self, expected: Iterable[Link], link_timeout: float,
                 restart_timeout: float) -> None:
        self._links: Dict[Link, _LinkState] = {link: _LinkState() for link in expected}
        self._link_timeout = link_timeout
        self._restart_timeout = restart_timeout

    @property
    def are_expected(self) -> bool:
        """Whether the robot is driven over any of them."""
        return bool(self._links)

    def update(self, report: LinkReported, now: float) -> None:
        """Takes a node's report on its link."""
        if report.link in self._links:
            self._links[report.link].update(report, now, self._restart_timeout)

    def stands(self, link: Link, now: float) -> bool:
        """Whether the link is up and its node alive; a link that is not expected always is."""
        state = self._links.get(link)
        return state is None or (state.up and not state.node_is_away(now))

    def up_since(self, link: Link) -> float:
        """When the link last came up, or its node came back; -inf for a link not expected."""
        state = self._links.get(link)
        return -math.inf if state is None else state.changed

    def why_unusable(self, now: float) -> Reason:
        """Why the robot cannot be driven at this moment."""
        for link, state in self._links.items():
            if state.heard is None:
                return Reason(ReasonCode.NOT_READY,
                              f'nothing is known of the link {link.value}')
            if state.node_is_away(now) and state.up:
                return _node_is_away(link, now - state.heard)
            if not state.up:
                return _lost(link, state.reason)
        return NO_REASON

    def why_lost(self, now: float) -> Reason:
        """Why a link must be given up."""
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


def _node_is_away(link: Link, seconds: float) -> Reason:
    return _lost(link, f'its node has reported nothing for {seconds:.0f} s')


def _lost(link: Link, why: str) -> Reason:
    return Reason(ReasonCode.LOST_LINK, f'lost link: {link.value}: {why}')
