"""Why a robot cannot be given anything to drive, and how it comes back."""
from __future__ import annotations

from enum import Enum


class Outage(Enum):
    """What keeps a robot from working; the values are words for people."""

    UNSEEN = 'it has not reported yet'
    SILENT = 'it does not report'
    DEAF = 'it reports, but does not answer its orders'
    LOST_LINK = 'the link to it was lost'
    STOPPED = 'emergency stop'
    TAKEN_OVER = 'somebody else drove it'
    FAILED = 'its route failed'
    OFF_GRAPH = 'it is off the graph'
    OUT_OF_SERVICE = 'it was taken out of service'

    @property
    def needs_person(self) -> bool:
        """Does it come back only by `fleet in`?"""
        return self in (Outage.TAKEN_OVER, Outage.FAILED, Outage.OFF_GRAPH, Outage.OUT_OF_SERVICE)


def outage_of(reason: str) -> Outage:
    """The outage that the reason of a failed or refused route means, as the protocol words it."""
    words = reason.lower()
    if words.startswith('emergency stop'):
        return Outage.STOPPED
    if words.startswith('lost link'):
        return Outage.LOST_LINK
    if words.startswith('taken over'):
        return Outage.TAKEN_OVER
    return Outage.FAILED
