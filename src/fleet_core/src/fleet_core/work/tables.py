"""The states of steps, stops and loads, and one table of transitions for each."""
from __future__ import annotations

from enum import Enum
from typing import Mapping, Tuple, TypeVar

State = TypeVar('State', bound=Enum)
Event = TypeVar('Event', bound=Enum)


class StepState(Enum):
    """The state of a step."""

    WAITING = 'waiting'
    RUNNING = 'running'
    ASK = 'ask'           # a person must decide what follows; until then no later step begins
    DONE = 'done'
    FAILED = 'failed'
    CANCELLED = 'cancelled'

    @property
    def is_final(self) -> bool:
        """Whether the step has ended."""
        return self in (StepState.DONE, StepState.FAILED, StepState.CANCELLED)


class StepEvent(Enum):
    """What changes the state of a step."""

    SEND = 'it is ordered, under a new key'
    DONE = 'it is known to be done'
    FAIL = 'it is known to have failed, and is not repeated'
    RETRY = 'it is known to have ended, and is repeated'
    ASK = 'a person must decide'
    CANCEL = 'it is not to be done any more'


class StopState(Enum):
    """The state of a stop."""

    WAITING = 'waiting'
    DRIVING = 'driving'   # it is the next stop; steps BEFORE_ENTRY may run
    AT_WORK = 'at work'   # the robot stands there; if it is moved away, the stop is DRIVING again
    DONE = 'done'
    FAILED = 'failed'
    SKIPPED = 'skipped'

    @property
    def is_final(self) -> bool:
        """Whether the stop has ended, whether the robot made it or not."""
        return self in (StopState.DONE, StopState.FAILED, StopState.SKIPPED)


class StopEvent(Enum):
    """What changes the state of a stop."""

    GO = 'it is the next one'
    ARRIVE = 'the robot stands there'
    MOVED = 'the robot was moved away'
    PART = 'its robot does not serve the mission any more'
    PASS = 'there is nothing to do any more, and the robot does not stand there'
    LEAVE = 'the robot may go on'
    FAIL = 'one of its steps has failed'
    SKIP = 'the mission ends before it'


class LoadState(Enum):
    """What is known of the load of a robot."""

    EMPTY = 'empty'
    LOADED = 'loaded'
    UNKNOWN = 'unknown'


class LoadEvent(Enum):
    """What changes the load of a robot, or what is known of it."""

    BEGIN = 'a step that takes or gives begins'
    FILLED = 'such a step has ended, and the robot carries something'
    EMPTIED = 'such a step has ended, and the robot carries nothing'
    SAID_LOADED = 'a person says that the robot carries the load of its mission'
    SAID_EMPTY = 'a person says that the robot carries nothing'


def _rows(target: State, event: Event, *sources: State) -> Mapping[Tuple[State, Event], State]:
    return {(source, event): target for source in sources}


_S, _P, _L = StepState, StopState, LoadState
STEP: Mapping[Tuple[StepState, StepEvent], StepState] = {
    **_rows(_S.RUNNING, StepEvent.SEND, _S.WAITING),
    **_rows(_S.DONE, StepEvent.DONE, _S.RUNNING, _S.ASK),
    **_rows(_S.FAILED, StepEvent.FAIL, _S.RUNNING, _S.ASK),
    **_rows(_S.WAITING, StepEvent.RETRY, _S.RUNNING, _S.ASK),
    **_rows(_S.ASK, StepEvent.ASK, _S.RUNNING),
    **_rows(_S.CANCELLED, StepEvent.CANCEL, _S.WAITING, _S.RUNNING, _S.ASK)}
STOP: Mapping[Tuple[StopState, StopEvent], StopState] = {
    **_rows(_P.DRIVING, StopEvent.GO, _P.WAITING),
    **_rows(_P.AT_WORK, StopEvent.ARRIVE, _P.DRIVING),
    **_rows(_P.DRIVING, StopEvent.MOVED, _P.AT_WORK),
    **_rows(_P.WAITING, StopEvent.PART, _P.DRIVING, _P.AT_WORK),
    **_rows(_P.DONE, StopEvent.PASS, _P.WAITING, _P.DRIVING),
    **_rows(_P.DONE, StopEvent.LEAVE, _P.AT_WORK),
    **_rows(_P.FAILED, StopEvent.FAIL, _P.DRIVING, _P.AT_WORK),
    **_rows(_P.SKIPPED, StopEvent.SKIP, _P.WAITING, _P.DRIVING, _P.AT_WORK)}
LOAD: Mapping[Tuple[LoadState, LoadEvent], LoadState] = {
    **_rows(_L.UNKNOWN, LoadEvent.BEGIN, _L.EMPTY, _L.LOADED, _L.UNKNOWN),
    **_rows(_L.LOADED, LoadEvent.FILLED, _L.UNKNOWN),
    **_rows(_L.EMPTY, LoadEvent.EMPTIED, _L.UNKNOWN),
    **_rows(_L.LOADED, LoadEvent.SAID_LOADED, *LoadState),
    **_rows(_L.EMPTY, LoadEvent.SAID_EMPTY, *LoadState)}


class NoTransition(Exception):
    """A table has no row for an event in a state: the caller has a defect."""


def after(table: Mapping[Tuple[State, Event], State], state: State, event: Event) -> State:
    """Returns the state after an event. Raises NoTransition."""
    try:
        return table[state, event]
    except KeyError:
        raise NoTransition(f'{state} has no {event}') from None
