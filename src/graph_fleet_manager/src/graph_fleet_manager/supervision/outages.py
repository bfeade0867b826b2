"""Why a robot cannot be given anything to drive, and how it comes back."""
from __future__ import annotations

from enum import Enum
from typing import Dict

from trajectory_graph.route_protocol import Reason, ReasonCode


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


_OF_REASON: Dict[ReasonCode, Outage] = {
    ReasonCode.EMERGENCY_STOP: Outage.STOPPED, ReasonCode.LOST_LINK: Outage.LOST_LINK,
    ReasonCode.TAKEN_OVER: Outage.TAKEN_OVER}


def outage_of(reason: Reason) -> Outage:
    """The outage that the reason of a failed or refused route means."""
    return _OF_REASON.get(reason.code, Outage.FAILED)
