"""A device that exists in this program only, for simulated sites and tests, with faults."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Callable, List, Optional, Sequence

from fleet_devices.core.device import Reading
from fleet_devices.core.hand_over import Signals, StartSignal
from fleet_devices.drivers.driver import Silent

SLOWER = 5.0  # how many times longer a slow device takes


class FaultKind(Enum):
    """A fault of a simulated device."""

    SLOW = 'slow'      # it takes SLOWER times as long
    STUCK = 'stuck'    # it does not move
    SILENT = 'silent'  # it does not answer, and does not obey
    LYING = 'lying'    # its input says the opposite
    SHUT = 'shut'      # it closes by itself, even if its output is on
    FAILING = 'failing'  # each hand-over fails


FAULTS_OF_DOORS = tuple(kind for kind in FaultKind if kind is not FaultKind.FAILING)
FAULTS_OF_MACHINES = tuple(kind for kind in FaultKind if kind is not FaultKind.SHUT)


@dataclass(frozen=True)
class ScriptedFault:
    """A fault from `begin` until `end`, in s after the start."""

    kind: FaultKind
    begin: float
    end: float


class SimulatedDevice:
    """A door that moves at a constant speed. It opens while its output is on, and closes while it
    is off.

    clock  -- s, from any beginning
    travel -- s from closed to open
    """

    def __init__(self, clock: Callable[[], float], travel: float,
                 faults: Sequence[ScriptedFault] = ()) -> None:
        self._clock, self._travel, self._faults = clock, travel, tuple(faults)
        self._start = self._moved = clock()
        self._output = False
        self._width = 0.0  # 0: closed, 1: open

    @property
    def is_passable(self) -> bool:
        """Whether it is really open."""
        self._move()
        return self._width >= 1.0

    def exchange(self, output: Optional[bool]) -> Reading:
        """Sets the output, and reads the device. Raises Silent."""
        self._move()
        if self._has(FaultKind.SILENT):
            raise Silent('it is silent, as its script says')
        if output is not None:
            self._output = output
        is_open = self._width >= 1.0
        return Reading(self._output, is_open is not self._has(FaultKind.LYING))

    def _move(self) -> None:
        now = self._clock()
        passed, self._moved = now - self._moved, now
        if self._has(FaultKind.STUCK):
            return
        opens = self._output and not self._has(FaultKind.SHUT)
        way = passed / (self._travel * (SLOWER if self._has(FaultKind.SLOW) else 1.0))
        self._width = min(max(self._width + (way if opens else -way), 0.0), 1.0)

    def _has(self, kind: FaultKind) -> bool:
        return _has(self._faults, kind, self._clock() - self._start)


class SimulatedHandOver:
    """A device that carries out hand-overs. Each takes `seconds` after the start signal.

    clock -- s, from any beginning
    """

    def __init__(self, clock: Callable[[], float], seconds: float,
                 faults: Sequence[ScriptedFault] = ()) -> None:
        self._clock, self._seconds, self._faults = clock, seconds, tuple(faults)
        self._start = self._moved = clock()
        self._is_on, self._key = False, 0
        self._worked = 0.0
        self._has_failed = False
        self.done: List[int] = []
        """The keys of the hand-overs that it has made, in their order."""

    def exchange(self, start: Optional[StartSignal]) -> Signals:
        """Writes the start, and reads the device. Raises Silent."""
        self._move()
        if self._has(FaultKind.SILENT):
            raise Silent('it is silent, as its script says')
        if start is not None:
            if start.is_on:
                self._key = start.key
            if start.is_on is not self._is_on:
                self._worked, self._has_failed = 0.0, False
            self._is_on = start.is_on
        is_over = self._is_on and self._worked >= self._seconds
        is_done = is_over and not self._has_failed
        return Signals(self._is_on, self._key, is_done is not self._has(FaultKind.LYING),
                       is_over and self._has_failed)

    def _move(self) -> None:
        now = self._clock()
        passed, self._moved = now - self._moved, now
        if not self._is_on or self._worked >= self._seconds or self._has(FaultKind.STUCK):
            return
        self._worked += passed / (SLOWER if self._has(FaultKind.SLOW) else 1.0)
        if self._worked >= self._seconds:
            self._has_failed = self._has(FaultKind.FAILING)
            if not self._has_failed:
                self.done.append(self._key)

    def _has(self, kind: FaultKind) -> bool:
        return _has(self._faults, kind, self._clock() - self._start)


def _has(faults: Sequence[ScriptedFault], kind: FaultKind, time: float) -> bool:
    return any(one.kind is kind and one.begin <= time < one.end for one in faults)
