"""The work of one mission: the progress of its stops and steps, and the load of its robot.

All objects here are immutable values. `work.rules` has the rules for new values. A `Situation` is
stored as a whole, before anything that follows from it is sent.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import FrozenSet, Iterable, NamedTuple, Optional, Tuple

from fleet_core.work.stops import WorkStep, WorkStop
from fleet_core.work.tables import LoadState, StepState, StopState

ANY_LOAD = ''  # the type of a load whose type is not known


class Seen(Enum):
    """What reports have shown of the last order of a step."""

    NOTHING = 'nothing'   # the robot has not shown it: it may not have received the command yet
    RUNNING = 'running'
    OVER = 'over'         # it has ended, or its actor cannot carry it out any more


class Ending(Enum):
    """How a mission ends before its last stop; NONE: it does not end early."""

    NONE = ''
    CANCEL = 'cancel'
    FAIL = 'fail'


@dataclass(frozen=True)
class StepProgress:
    """The progress of one step.

    key      -- number under which the step was ordered last; 0: the step was never ordered
    run      -- run number of its robot or device when the step was ordered
    begun    -- the time at which it was ordered, in ms since 1970
    times_ordered -- how many times it was ordered
    is_ended -- it must not begin any more; if it runs, it must end if its actor can end it
    text     -- for people: why the step failed, or why a person is asked
    """

    state: StepState = StepState.WAITING
    key: int = 0
    run: int = 0
    begun: int = 0
    times_ordered: int = 0
    seen: Seen = Seen.OVER
    is_ended: bool = False
    text: str = ''


@dataclass(frozen=True)
class StopProgress:
    """The progress of one stop and of its steps."""

    state: StopState = StopState.WAITING
    steps: Tuple[StepProgress, ...] = ()


class StepPlace(NamedTuple):
    """The numbers of a stop and of one of its steps, from 0."""

    stop: int
    step: int


@dataclass(frozen=True)
class Work:
    """The stops of a mission and their progress.

    stops     -- stops that have been made, and stops that are to be made
    on_cancel -- stops that may follow a cancellation
    is_cut    -- the mission ends early, so stops of `on_cancel` have replaced the remaining stops
    reason    -- why the mission ends, for people
    """

    stops: Tuple[WorkStop, ...]
    progress: Tuple[StopProgress, ...]
    on_cancel: Tuple[WorkStop, ...] = ()
    ending: Ending = Ending.NONE
    is_cut: bool = False
    reason: str = ''

    @property
    def is_ending(self) -> bool:
        """Whether the mission is to end early, but a step that it has begun has not ended yet."""
        return self.ending is not Ending.NONE and not self.is_cut

    @cached_property
    def current(self) -> int:
        """Number of the stop that is made now or next; after the last stop, the number of stops."""
        return next((k for k, stop in enumerate(self.progress) if not stop.state.is_final),
                    len(self.progress))

    @cached_property
    def steps(self) -> Tuple[Tuple[StepPlace, WorkStep, StepProgress], ...]:
        """All steps, in the order of the stops."""
        return tuple((StepPlace(k, n), step, own)
                     for k, (stop, progress) in enumerate(zip(self.stops, self.progress))
                     for n, (step, own) in enumerate(zip(stop.steps, progress.steps)))

    def step(self, place: StepPlace) -> WorkStep:
        """Returns the step in a place."""
        return self.stops[place.stop].steps[place.step]

    def progress_of(self, place: StepPlace) -> StepProgress:
        """Returns the progress of the step in a place."""
        return self.progress[place.stop].steps[place.step]

    def with_step(self, place: StepPlace, own: StepProgress) -> Work:
        """Returns the work with a new progress of one step."""
        stop = self.progress[place.stop]
        steps = (*stop.steps[:place.step], own, *stop.steps[place.step + 1:])
        return self.with_stop(place.stop, replace(stop, steps=steps))

    def with_stop(self, number: int, stop: StopProgress) -> Work:
        """Returns the work with a new progress of one stop."""
        return replace(self, progress=(*self.progress[:number], stop,
                                       *self.progress[number + 1:]))

    @cached_property
    def asking(self) -> Optional[StepPlace]:
        """The first step that waits for the answer of a person; None: no step waits."""
        return next((place for place, _, own in self.steps if own.state is StepState.ASK), None)

    @property
    def answerable(self) -> Optional[StepPlace]:
        """The step that `mission answer` answers: it is in ASK, or runs and has no driver."""
        others = (place for place, step, own in self.steps
                  if own.state is StepState.RUNNING and not step.actor.has_driver)
        return self.asking or next(others, None)


@dataclass(frozen=True)
class RobotLoad:
    """The load of a robot.

    serial -- serial of the mission whose load it is; 0: none
    count  -- number of pieces; while the state is UNKNOWN, the last known number
    types  -- names of the types of load that the robot may carry, sorted; None: not known
    """

    state: LoadState = LoadState.EMPTY
    serial: int = 0
    count: int = 0
    types: Optional[Tuple[str, ...]] = None

    @property
    def may_be(self) -> FrozenSet[str]:
        """The types of load that the robot may carry. `ANY_LOAD`: a load of unknown type."""
        if self.state is LoadState.EMPTY:
            return frozenset()
        return frozenset((ANY_LOAD,) if self.types is None else self.types)

    def with_types(self, types: Iterable[str]) -> RobotLoad:
        """Returns the same load, but the robot may now carry these types, too."""
        return replace(self, types=tuple(sorted(self.may_be.union(types))))

    def is_bound_to(self, serial: int) -> bool:
        """Returns whether the robot must serve this mission because of its load."""
        return self.state is not LoadState.EMPTY and self.serial == serial


class Situation(NamedTuple):
    """The work of a mission, and the load of the robot that does it."""

    serial: int
    work: Work
    load: RobotLoad = RobotLoad()


def work_of(stops: Tuple[WorkStop, ...], on_cancel: Tuple[WorkStop, ...] = ()) -> Work:
    """Returns the work of a mission that has not begun."""
    return Work(stops, tuple(map(progress_of, stops)), on_cancel)


def progress_of(stop: WorkStop) -> StopProgress:
    """Returns the progress of a stop that has not begun."""
    return StopProgress(steps=tuple(StepProgress() for _ in stop.steps))
