"""A job that is handed to a Fleet Manager, and its states.

    state        event       next state
    STORED       SENDING     SENT
                 WITHDRAWN   CANCELLED
    SENT         ACCEPTED    ACCEPTED
                 STARTED     IN_PROGRESS
                 NOT_KNOWN   STORED: it has certainly not arrived, and may be sent again
                 FORGOTTEN   UNKNOWN
                 REFUSED     REFUSED
    ACCEPTED     STARTED     IN_PROGRESS
    IN_PROGRESS  ACCEPTED    ACCEPTED: it waits again, for example after an interruption
    SENT, ACCEPTED, IN_PROGRESS
                 COMPLETED, CANCELLED, FAILED     that state
    ACCEPTED, IN_PROGRESS
                 NOT_KNOWN, FORGOTTEN             UNKNOWN: it was there, and its end was not heard

Each other pair changes nothing. Invariants: the last five states are final; only STORED leads to
SENT, and nothing but NOT_KNOWN leads back to STORED.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import Dict, Mapping, Optional, Tuple


class HandedState(IntEnum):
    """The state of a job, with the numbers of the message JobStatus."""

    STORED = 0
    SENT = 1
    ACCEPTED = 2
    IN_PROGRESS = 3
    COMPLETED = 4
    CANCELLED = 5
    FAILED = 6
    REFUSED = 7
    UNKNOWN = 8


class HandedEvent(Enum):
    """What becomes known of a job."""

    SENDING = 'its command is to be sent'
    WITHDRAWN = 'it is cancelled before it was sent'
    ACCEPTED = 'the Fleet Manager has it, and it waits'
    STARTED = 'a robot serves it'
    COMPLETED = 'all its segments are completed'
    CANCELLED = 'all its segments have ended, and one was cancelled'
    FAILED = 'all its segments have ended, and one has failed'
    NOT_KNOWN = 'the Fleet Manager does not know it'
    FORGOTTEN = 'the Fleet Manager does not know it; it may have done it long ago'
    REFUSED = 'the Fleet Manager refused it, and does not know it'


_S, _E = HandedState, HandedEvent
_ENDS: Mapping[HandedEvent, HandedState] = {
    _E.COMPLETED: _S.COMPLETED, _E.CANCELLED: _S.CANCELLED, _E.FAILED: _S.FAILED}
TRANSITIONS: Mapping[Tuple[HandedState, HandedEvent], HandedState] = {
    (_S.STORED, _E.SENDING): _S.SENT,
    (_S.STORED, _E.WITHDRAWN): _S.CANCELLED,
    (_S.SENT, _E.ACCEPTED): _S.ACCEPTED,
    (_S.SENT, _E.STARTED): _S.IN_PROGRESS,
    (_S.SENT, _E.NOT_KNOWN): _S.STORED,
    (_S.SENT, _E.FORGOTTEN): _S.UNKNOWN,
    (_S.SENT, _E.REFUSED): _S.REFUSED,
    (_S.ACCEPTED, _E.STARTED): _S.IN_PROGRESS,
    (_S.IN_PROGRESS, _E.ACCEPTED): _S.ACCEPTED,
    **{(state, event): end for event, end in _ENDS.items()
       for state in (_S.SENT, _S.ACCEPTED, _S.IN_PROGRESS)},
    **{(state, event): _S.UNKNOWN for event in (_E.NOT_KNOWN, _E.FORGOTTEN)
       for state in (_S.ACCEPTED, _S.IN_PROGRESS)},
}


class HandedStopKind(Enum):
    """What a robot does at a goal."""

    PICKUP = 'pickup'
    DROPOFF = 'dropoff'


@dataclass(frozen=True)
class HandedStop:
    """A goal of a job. `priority` None: the Fleet Manager's default."""

    goal: str
    kind: HandedStopKind
    priority: Optional[int] = None


@dataclass(frozen=True)
class HandedJob:
    """A job.

    id        -- of the job at the Fleet Manager; never used twice
    request   -- the caller's id of the job, or empty
    sent      -- when its command was sent last; ms, wall clock
    segments  -- by its id, the last status of each segment
    is_unwanted -- whether it is to be cancelled
    reason    -- the Fleet Manager's words for a refusal
    """

    id: str
    stops: Tuple[HandedStop, ...]
    request: str = ''
    state: HandedState = HandedState.STORED
    sent: int = 0
    segments: Tuple[Tuple[str, str], ...] = ()
    robot: str = ''
    is_unwanted: bool = False
    reason: str = ''

    @property
    def is_open(self) -> bool:
        """Whether it has not ended."""
        return self.state <= HandedState.IN_PROGRESS

    @property
    def is_in_hand(self) -> bool:
        """Whether the Fleet Manager may have it."""
        return self.is_open and self.state is not HandedState.STORED

    def after(self, event: HandedEvent) -> HandedJob:
        """The job after an event."""
        return replace(self, state=TRANSITIONS.get((self.state, event), self.state))

    def with_segment(self, id: str, status: str, robot: str) -> HandedJob:
        """The job after a line about one of its segments; an ended job does not change.

        A line about one segment more than the job has is ignored.
        """
        segments: Dict[str, str] = {**dict(self.segments), id: status}
        if not self.is_open or len(segments) > len(self.stops):
            return self
        changed = replace(self, segments=tuple(segments.items()), robot=robot or self.robot)
        return changed.after(_event_of(tuple(segments.values()), len(self.stops)))

    def after_listing(self, listed: Tuple[str, ...]) -> HandedJob:
        """The job after a listing of the segments that the Fleet Manager still knows.

        It forgets segments in the order in which they ended, and a segment begins when the one
        before it is completed. So if no open one is listed, the job has ended as those that are.
        """
        known = tuple((id, status) for id, status in self.segments
                      if id in listed or status in FINAL_STATUSES)
        if not self.is_open or any(status not in FINAL_STATUSES for _, status in known):
            return self
        return replace(self, segments=known).after(
            _event_of(tuple(status for _, status in known), len(known)))


FINAL_STATUSES = ('Completed', 'Cancelled', 'Cancelled_by_MobilePlanner', 'Failed')


def _event_of(statuses: Tuple[str, ...], count: int) -> HandedEvent:
    """What the statuses of the segments say of their job."""
    if len(statuses) >= count and all(status in FINAL_STATUSES for status in statuses):
        if 'Failed' in statuses:
            return HandedEvent.FAILED
        return (HandedEvent.COMPLETED if all(status == 'Completed' for status in statuses)
                else HandedEvent.CANCELLED)
    begun = any(status not in ('Pending', 'BeforeModify', 'AfterModify') for status in statuses)
    return HandedEvent.STARTED if begun else HandedEvent.ACCEPTED
