"""The state of a connection, and the waiting time before the next attempt to connect.

    phase           event                                               next phase
    DISCONNECTED    the waiting time is over                            CONNECTING
    CONNECTING      the socket is open                                  LOGGING_IN
    LOGGING_IN      the session is ready                                CONNECTED
                    the robot refuses the password                      WRONG_PASSWORD
    WRONG_PASSWORD  the longer waiting time is over                     CONNECTING
    all             the connection fails or ends, or no line comes      DISCONNECTED
                    for too long

A listener is only DISCONNECTED or CONNECTED. Lines and commands are exchanged only while CONNECTED.
"""
from __future__ import annotations

import random
from dataclasses import dataclass
from enum import Enum

from omron_arcl.errors import LinkError, WrongPassword


class LinkPhase(Enum):
    """The phase of a link."""

    DISCONNECTED = 'disconnected'
    CONNECTING = 'connecting'
    LOGGING_IN = 'logging in'
    CONNECTED = 'connected'
    WRONG_PASSWORD = 'wrong password'


@dataclass(frozen=True)
class Link:
    """State of a link.

    `peer` is host:port. `reason` says why the link is not connected, or what is wrong with it.
    """

    phase: LinkPhase
    peer: str
    reason: str = ''

    @property
    def connected(self) -> bool:
        """Whether commands and lines can be exchanged."""
        return self.phase is LinkPhase.CONNECTED


class Backoff:
    """The waiting time (s) before the next attempt to connect.

    The time doubles after each attempt, from `first` to `cap`; `jitter` is the share by which it
    varies at random. After a wrong password, the waiting time is `wrong_password`: a person has to
    correct the password first, and robots may count the attempts.
    """

    def __init__(self, first: float = 0.5, cap: float = 10.0, jitter: float = 0.2,
                 wrong_password: float = 30.0) -> None:
        self.first = first
        self.cap = cap
        self.jitter = jitter
        self.wrong_password = wrong_password
        self._next = first

    def after(self, cause: LinkError) -> float:
        """Returns the waiting time (s) after a connection failed or ended because of `cause`."""
        if isinstance(cause, WrongPassword):
            return self.wrong_password
        delay = self._next * random.uniform(1.0 - self.jitter, 1.0 + self.jitter)
        self._next = min(self._next * 2.0, self.cap)
        return min(delay, self.cap)

    def reset(self) -> None:
        """Notes that a connection succeeded: the next waiting time is `first` again."""
        self._next = self.first

