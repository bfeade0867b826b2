"""The steps of one simulated AGV: its memory of them, their durations, and requested faults.

Every type of step is carried out. Its duration is the parameter `seconds`, or `SECONDS` without
this parameter. A simulation may draw the duration instead.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, Tuple

from route_protocol.steps import ActorState, Reaction, StepCode, StepCommand, StepReport, Word

SECONDS = 2.0   # s; duration of a step without the parameter `seconds`
LONGEST = 1e6   # s


@dataclass
class _Running:
    """A step that is being carried out: its type, the seconds left, and how it will end."""

    type: str
    left: float
    end: Word


def asked_seconds(command: StepCommand) -> float:
    """Returns the duration (s) that a command requests; NaN: it is not a number."""
    try:
        return float(dict(command.parameters).get('seconds', SECONDS))
    except ValueError:
        return math.nan


class SimulatedSteps:
    """Carries out the steps of one AGV.

    draw    -- returns the number of a new run; called at each start of the AGV's driver
    seconds -- returns the seconds that the step of a command takes
    """

    def __init__(self, draw: Callable[[], int],
                 seconds: Callable[[StepCommand], float] = asked_seconds) -> None:
        self._draw, self._seconds = draw, seconds
        self._state = ActorState(draw())
        self._running: Dict[int, _Running] = {}
        self._faults: List[Word] = []
        self.done: List[str] = []
        """The types of the steps that were carried out to their end, the earliest first."""

    @property
    def news(self) -> object:
        """The values whose changes are reported at once."""
        return self._state.run, self._state.last, self._state.steps

    @property
    def running(self) -> Tuple[str, ...]:
        """The types of the steps that are being carried out."""
        return tuple(step.type for step in self._running.values())

    def report(self) -> StepReport:
        """Returns the next report."""
        self._state, report = self._state.report()
        return report

    def receive(self, command: StepCommand) -> None:
        """Handles a command."""
        self._state, reaction = self._state.obey(command)
        if reaction is Reaction.BEGIN:
            self._begin(command)
        elif reaction is Reaction.BREAK_OFF:
            self._end(command.key, Word.CANCELLED)

    def _begin(self, command: StepCommand) -> None:
        seconds = self._seconds(command)
        if not 0.0 <= seconds <= LONGEST:
            self._state = self._state.end(command.key, Word.FAILED, StepCode.WRONG_PARAMETER,
                                          f'seconds must be a number from 0 to {LONGEST:.0f}')
            return
        fault = self._faults.pop(0) if self._faults else Word.DONE
        self._running[command.key] = _Running(
            command.type, math.inf if fault is Word.RUNNING else seconds, fault)

    def advance(self, seconds: float) -> None:
        """Simulates the next `seconds`."""
        for key, step in list(self._running.items()):
            step.left -= seconds
            if step.left <= 0.0:
                self._end(key, step.end)

    def _end(self, key: int, word: Word) -> None:
        step = self._running.pop(key)
        if word in (Word.DONE, Word.UNKNOWN):
            self.done.append(step.type)
        is_wrong = word in (Word.FAILED, Word.UNKNOWN)
        self._state = self._state.end(key, word, StepCode.OTHER if is_wrong else StepCode.NONE,
                                      'fault on demand' if is_wrong else '')

    # -- faults -----------------------------------------------------------------------------------

    def fail_next(self, word: Word, count: int) -> None:
        """Lets the next `count` steps end with `word`; RUNNING: they never end."""
        self._faults += [word] * count

    def restart(self) -> None:
        """Restarts the driver, which forgets its steps and breaks off the running ones."""
        self._state = ActorState(max(self._draw(), self._state.run + 1))
        self._running.clear()
