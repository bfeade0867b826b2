"""The state of a connection as data, and how long to wait before the next try."""
from __future__ import annotations

import random
from dataclasses import dataclass
from enum import Enum

from omron_arcl.errors import LinkError, WrongPassword


class LinkPhase(Enum):
    """Where a link is."""

    DISCONNECTED = 'disconnected'
    CONNECTING = 'connecting'
    LOGGING_IN = 'logging in'
    CONNECTED = 'connected'
    WRONG_PASSWORD = 'wrong password'


@dataclass(frozen=True)
class Link:
    """State of a link: `peer` is host:port, `reason` why it is not connected."""

    phase: LinkPhase
    peer: str
    reason: str = ''

    @property
    def connected(self) -> bool:
        """Whether commands and lines go through."""
        return self.phase is LinkPhase.CONNECTED


class Backoff:
    """Seconds until the next try: doubling from `first` to `cap`, spread by `jitter` (a share).

    A wrong password is tried again after `wrong_password` s: a person has to mend it first, and
    robots may count the tries.
    """

    def __init__(self, first: float = 0.5, cap: float = 10.0, jitter: float = 0.2,
                 wrong_password: float = 30.0) -> None:
        self.first = first
        self.cap = cap
        self.jitter = jitter
        self.wrong_password = wrong_password
        self._next = first

    def after(self, cause: LinkError) -> float:
        """The wait after a connection that ended, or did not come about, for `cause`."""
        if isinstance(cause, WrongPassword):
            return self.wrong_password
        delay = self._next * random.uniform(1.0 - self.jitter, 1.0 + self.jitter)
        self._next = min(self._next * 2.0, self.cap)
        return min(delay, self.cap)

    def reset(self) -> None:
        """A connection worked."""
        self._next = self.first

