"""The time and distance that the robot spent in each state, for its data store."""
from __future__ import annotations

from enum import Enum
from typing import Dict, Optional, Tuple

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.motion.base import Base

Sum = Tuple[float, float]       # seconds, mm


class WorkState(Enum):
    """A state of a robot without a fleet manager; the value is its name in the data store."""

    DOCKING = 'Docking'
    DOCKED = 'Docked'
    IN_FAULT = 'InFault'
    IN_ESTOP = 'InEstop'


class StateTimes:
    """Times and distances since the start and the last trip reset; at most one state is active."""

    def __init__(self, clock: SimClock, base: Base) -> None:
        self._clock, self._base = clock, base
        self._sums: Dict[WorkState, Sum] = dict.fromkeys(WorkState, (0.0, 0.0))
        self._state: Optional[WorkState] = None
        self._since = self._now()
        self.reset_trip()

    def _now(self) -> Sum:
        return self._clock.now, self._base.driven

    def enter(self, state: Optional[WorkState]) -> None:
        """Enters `state`; None: a state whose time is not counted."""
        now = self._now()
        if self._state is not None:
            self._sums[self._state] = _plus(self._sums[self._state], _minus(now, self._since))
        self._state, self._since = state, now

    def total(self, state: WorkState) -> Sum:
        """Returns the seconds and mm since the start."""
        self.enter(self._state)
        return self._sums[state]

    def trip(self, state: WorkState) -> Sum:
        """Returns the seconds and mm since the trip reset."""
        return _minus(self.total(state), self._trip_zero[state])

    @property
    def trip_seconds(self) -> float:
        """Seconds since the trip reset."""
        return self._clock.now - self._trip_start

    def reset_trip(self) -> None:
        """Begins a new trip."""
        self._trip_start = self._clock.now
        self._trip_zero = {state: self.total(state) for state in WorkState}


def _plus(a: Sum, b: Sum) -> Sum:
    return a[0] + b[0], a[1] + b[1]


def _minus(a: Sum, b: Sum) -> Sum:
    return a[0] - b[0], a[1] - b[1]
