"""The record of a fleet stop: its author, time and reason. The supervisor owns the record.

The stop lasts until a person lets the fleet go on. It outlasts restarts, because the journal keeps
the record.
"""
from __future__ import annotations

import time
from dataclasses import dataclass
from enum import IntEnum


class StopCause(IntEnum):
    """Why the fleet is stopped, as in itrci_nav_msgs/FleetStop."""

    NONE = 0
    """It is not stopped."""
    PERSON = 1
    """A person or a program has stopped it."""
    BYPASSED = 2
    """A robot got a stop that bypassed the fleet manager."""
    DEFECT = 3
    """The fleet manager has found an error of its own."""
    UNKNOWN = 4
    """An older version of this program has stored the stop, without author, time and reason."""


@dataclass(frozen=True)
class FleetStop:
    """Whether the fleet is stopped, and since when.

    by    -- the person or program that stopped it; empty: none is named
    since -- s since 1970; 0: unknown
    why   -- what happened, as a clause; empty: `cause` says everything
    """

    cause: StopCause = StopCause.NONE
    by: str = ''
    since: float = 0.0
    why: str = ''

    @property
    def is_in_force(self) -> bool:
        """Whether the fleet is stopped."""
        return self.cause is not StopCause.NONE

    def words(self, now: float) -> str:
        """Returns a text about the stop, in local time; empty: the fleet is not stopped.

        now -- s since 1970
        """
        if not self.is_in_force:
            return ''
        told = 'The fleet is stopped'
        if self.since:
            began, today = time.localtime(self.since), time.localtime(now)
            form = '%H:%M:%S' if began[:3] == today[:3] else '%Y-%m-%d %H:%M:%S'
            told += f' since {time.strftime(form, began)}'
        if self.by:
            told += f', by {self.by}'
        return told + (f': {self.why}.' if self.why else '.')


NOT_STOPPED = FleetStop()
