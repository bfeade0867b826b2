"""The links to the robot: which stand, which are down and since when."""
from __future__ import annotations

import math
from typing import Dict, Iterable, NamedTuple

from omron_ld90.bridge.route_protocol import LinkChanged


class _Outage(NamedTuple):
    since: float  # s, monotonic
    reason: str


class RobotLinks:
    """What is known of each link; an empty text is no reason."""

    def __init__(self, expected: Iterable[str] = ()) -> None:
        """`expected` are the links of which word is to come."""
        self._unheard = set(expected)
        self._down: Dict[str, _Outage] = {}

    def update(self, event: LinkChanged, now: float) -> None:
        """Takes the news of a link."""
        self._unheard.discard(event.link)
        if event.up:
            self._down.pop(event.link, None)
        else:
            since = self._down[event.link].since if event.link in self._down else now
            self._down[event.link] = _Outage(since, event.reason)

    @property
    def all_stand(self) -> bool:
        """Whether no link is known to be down."""
        return not self._down

    def why_unknown(self) -> str:
        """Why nobody can tell whether the robot can be driven."""
        return next((f'nothing is known of the link {link}' for link in sorted(self._unheard)), '')

    def why_down(self) -> str:
        """Why the robot cannot be driven now."""
        return self.why_down_since(math.inf)

    def why_down_since(self, time: float) -> str:
        """The same, of a link that is down since before `time`."""
        return next((f'lost link: {link}: {outage.reason}' for link, outage in self._down.items()
                     if outage.since < time), '')
