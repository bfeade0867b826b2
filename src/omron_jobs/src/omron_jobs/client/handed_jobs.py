"""A job that is handed to a Fleet Manager, and its states.

    state        event       next state
    STORED       SENDING     SENT
                 WITHDRAWN   CANCELLED
    SENT         ACCEPTED    ACCEPTED
                 STARTED     IN_PROGRESS
                 NOT_KNOWN   STORED: it certainly did not arrive, and may be sent again
                 FORGOTTEN   UNKNOWN
                 REFUSED     REFUSED
    ACCEPTED     STARTED     IN_PROGRESS
    IN_PROGRESS  ACCEPTED    ACCEPTED: it waits again, for example after an interruption
    SENT, ACCEPTED, IN_PROGRESS
                 COMPLETED, CANCELLED, FAILED     the state of the same name
    ACCEPTED, IN_PROGRESS
                 NOT_KNOWN, FORGOTTEN             UNKNOWN: it had arrived, and its end was missed

All other pairs of state and event change nothing. Invariants: the last five values of HandedState
are final; only STORED leads to SENT; only NOT_KNOWN leads back to STORED.

A modification gives a job other goals or priorities. It is UNDER_WAY until the Fleet Manager shows
all new values (DONE), or refuses one of them (REFUSED). A job that was not sent gets them at once.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import Mapping, NamedTuple, Optional, Tuple


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


class Modification(IntEnum):
    """The state of the last modification, with the numbers of the message JobStatus."""

    NONE = 0
    UNDER_WAY = 1
    DONE = 2
    REFUSED = 3


class HandedEvent(Enum):
    """An event of a job."""

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
    """The act of a robot at a goal."""

    PICKUP = 'pickup'
    DROPOFF = 'dropoff'


@dataclass(frozen=True)
class HandedStop:
    """A goal of a job. `priority` None: the Fleet Manager's default."""

    goal: str
    kind: HandedStopKind
    priority: Optional[int] = None


@dataclass(frozen=True)
class HandedSegment:
    """A goal of a job as the Fleet Manager showed it last."""

    id: str
    status: str
    goal: str
    priority: int

    @property
    def is_final(self) -> bool:
        """Whether it has ended."""
        return self.status in FINAL_STATUSES

    @property
    def number(self) -> int:
        """The number in its id. One counter numbers all segments, so the numbers show their order.
        """
        digits = self.id[len(self.id.rstrip('0123456789')):]
        return int(digits) if digits else 0


class Change(NamedTuple):
    """A part of a modification: a value that a segment does not show yet."""

    segment: HandedSegment
    field: str      # goal or priority
    value: str


@dataclass(frozen=True)
class HandedJob:
    """A job. It is an immutable value that is stored as a whole.

    id        -- the job's id at the Fleet Manager; never used twice
    request   -- the caller's id of the job, or empty
    sent      -- when its command was sent last; ms, wall clock
    segments  -- its goals as the Fleet Manager showed them, in their order
    is_unwanted -- whether it is to be cancelled
    reason    -- why the Fleet Manager refused the job, or its modification
    wanted    -- its stops after the modification under way; empty: none is under way
    linked    -- for a swap: id of the job that drops off where this job picks up; empty: no swap
    """

    id: str
    stops: Tuple[HandedStop, ...]
    request: str = ''
    state: HandedState = HandedState.STORED
    sent: int = 0
    segments: Tuple[HandedSegment, ...] = ()
    robot: str = ''
    is_unwanted: bool = False
    reason: str = ''
    wanted: Tuple[HandedStop, ...] = ()
    modification: Modification = Modification.NONE
    linked: str = ''

    @property
    def is_open(self) -> bool:
        """Whether it has not ended."""
        return self.state <= HandedState.IN_PROGRESS

    @property
    def is_in_hand(self) -> bool:
        """Whether the Fleet Manager may have it."""
        return self.is_open and self.state is not HandedState.STORED

    def after(self, event: HandedEvent) -> HandedJob:
        """Returns the job after an event."""
        return replace(self, state=TRANSITIONS.get((self.state, event), self.state))

    def with_segment(self, segment: HandedSegment, robot: str) -> HandedJob:
        """Returns the job after a line about one of its segments. An ended job does not change.

        If the job has as many segments as stops already, a line about a new segment is ignored.
        """
        segments = {**{one.id: one for one in self.segments}, segment.id: segment}
        if not self.is_open or len(segments) > len(self.stops):
            return self
        found = tuple(sorted(segments.values(), key=lambda one: one.number))
        changed = replace(self, segments=found, robot=robot or self.robot)
        return changed.after(_event_of(found, len(self.stops)))

    def after_listing(self, listed: Tuple[str, ...]) -> HandedJob:
        """Returns the job after a listing of the segments that the Fleet Manager still knows.

        The Fleet Manager forgets segments in the order in which they ended. A segment begins when
        the segment before it is completed. So if no open segment is listed, the job has ended. Then
        the listed segments and the known final segments show how it ended.
        """
        known = tuple(one for one in self.segments if one.id in listed or one.is_final)
        if not self.is_open or any(not one.is_final for one in known):
            return self
        return replace(self, segments=known).after(_event_of(known, len(known)))

    # -- modifications -----------------------------------------------------------------------------

    def modified(self, stops: Tuple[HandedStop, ...]) -> HandedJob:
        """Returns the job with a modification under way."""
        return replace(self, wanted=stops, modification=Modification.UNDER_WAY, reason='')

    @property
    def changes(self) -> Tuple[Change, ...]:
        """The wanted values that segments do not show yet; empty if not all segments are known."""
        if len(self.segments) < len(self.stops):
            return ()
        return tuple(change for stop, segment in zip(self.wanted, self.segments)
                     for change in _changes_of(stop, segment))

    def settled(self) -> HandedJob:
        """Returns the job without its modification, if the modification has ended.

        If the job itself has ended, its modification counts as refused.
        """
        if not self.wanted:
            return self
        if self.state is HandedState.STORED or (
                len(self.segments) == len(self.stops) and not self.changes):
            return replace(self, stops=self.wanted, wanted=(), modification=Modification.DONE)
        return self if self.is_open else self.refused(self.reason or 'the job has ended')

    def refused(self, reason: str) -> HandedJob:
        """Returns the job after the refusal of its modification. It keeps the values that the Fleet
        Manager has shown already.
        """
        missing = {(change.segment.id, change.field) for change in self.changes}
        stops = self.stops
        if len(self.segments) == len(stops):
            stops = tuple(replace(
                old, goal=old.goal if (one.id, 'goal') in missing else new.goal,
                priority=old.priority if (one.id, 'priority') in missing else new.priority)
                for old, new, one in zip(stops, self.wanted, self.segments))
        return replace(self, stops=stops, wanted=(), modification=Modification.REFUSED,
                       reason=reason)


def _changes_of(stop: HandedStop, segment: HandedSegment) -> Tuple[Change, ...]:
    goal = () if stop.goal.lower() == segment.goal.lower() else (
        Change(segment, 'goal', stop.goal),)
    if stop.priority is None or stop.priority == segment.priority:
        return goal
    return (*goal, Change(segment, 'priority', str(stop.priority)))


FINAL_STATUSES = ('Completed', 'Cancelled', 'Cancelled_by_MobilePlanner', 'Failed')
MODIFYING_STATUSES = ('BeforeModify', 'InterruptedByModify', 'AfterModify')


def _event_of(segments: Tuple[HandedSegment, ...], count: int) -> HandedEvent:
    """Returns the event that follows from the segments of a job."""
    statuses = [one.status for one in segments]
    if len(segments) >= count and all(one.is_final for one in segments):
        if 'Failed' in statuses:
            return HandedEvent.FAILED
        return (HandedEvent.COMPLETED if all(status == 'Completed' for status in statuses)
                else HandedEvent.CANCELLED)
    begun = any(status not in ('Pending', *MODIFYING_STATUSES) for status in statuses)
    return HandedEvent.STARTED if begun else HandedEvent.ACCEPTED
