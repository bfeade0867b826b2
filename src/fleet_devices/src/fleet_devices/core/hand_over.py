"""One device that carries out steps: a press or a conveyor that hands something over to a robot.

The fleet manager orders a step of a device like a step of a robot (`route_protocol.steps`). The
device has a *start* output, and the inputs *done* and *failed*. When the driver writes the start
output, it also writes the key of the step. It reads the device by *exchanges*, one after the other.
State: the actor's memory of its steps, the phase, and the last readings.

    | phase     | meaning                                        | start output                |
    |-----------|------------------------------------------------|-----------------------------|
    | LEFT      | no step; the end of the last step is unknown   | as it is                    |
    | IDLE      | no step; the last step has ended               | off, until it reads off     |
    | READYING  | a step is ordered; its start was never written | off, until it reads off     |
    | WORKING   | its start was, or may have been, written once  | as it is                    |
    | BREAKING  | the step is to be broken off                   | off, until it reads off     |

    | event                                         | in                | then                     |
    |-----------------------------------------------|-------------------|--------------------------|
    | start without the memory: a new run begins    |                   | LEFT                     |
    | start with the memory                         | any               | the phase in the memory  |
    | DO with a new key                             | LEFT, IDLE        | READYING                 |
    | DO with a new key                             | a step runs       | the new step FAILED      |
    | DO of another kind of step                    | LEFT, IDLE        | FAILED                   |
    | an exchange begins, all signals read off      | READYING          | WORKING, writes start    |
    | an exchange begins, it reads start of this key| READYING          | WORKING                  |
    | CANCEL                                        | READYING          | CANCELLED, IDLE          |
    | CANCEL                                        | WORKING           | BREAKING                 |
    | reads done                                    | WORKING, BREAKING | DONE, IDLE               |
    | reads failed                                  | WORKING, BREAKING | FAILED, IDLE             |
    | reads another key, or both inputs             | WORKING, BREAKING | UNKNOWN, LEFT            |
    | reads no start                                | WORKING           | UNKNOWN, LEFT            |
    | the device's timeout is over                  | READYING          | FAILED, LEFT             |
    | the device's timeout is over                  | BREAKING          | UNKNOWN, LEFT            |
    | no reading for `offline_after`                | READYING          | FAILED, LEFT             |
    | no reading for `offline_after`                | WORKING, BREAKING | UNKNOWN, LEFT            |

"Reads" means `STEADY` equal readings, all from exchanges that began in this phase.

Invariants (`test_hand_over_states.py` checks them in all states, and fails if a rule is left out):

ONCE      the start of a key is written at most once, also across restarts
STORED    the start is written only after WORKING with this key was stored
TRUE      a started step is reported as DONE or FAILED only if the device shows this with its key
NOT BEGUN a step that ends as FAILED or CANCELLED in READYING was not started
ONE RUNS  at most one step runs
LIVE      a step ends if the device works, or is silent
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple, Optional, Tuple

from fleet_devices.core.device import STEADY, DeviceLimits
from route_protocol.steps import (
    HAND_OVER,
    ActorState,
    Reaction,
    ShownStep,
    StepCode,
    StepCommand,
    Word,
)

_REPORTS = 2 ** 32  # more report numbers than the driver needs between two starts


class HandOverPhase(Enum):
    """The phase of a step of a device."""

    LEFT = 'left as it is'
    IDLE = 'without a step'
    READYING = 'is to get ready'
    WORKING = 'at work'
    BREAKING = 'is to be broken off'


RUNNING = frozenset({HandOverPhase.READYING, HandOverPhase.WORKING, HandOverPhase.BREAKING})


class Signals(NamedTuple):
    """A reading of a device: its start output, the key, and its two inputs."""

    start: bool
    key: int
    done: bool
    failed: bool

    @property
    def are_off(self) -> bool:
        """Whether a step may begin."""
        return not (self.start or self.done or self.failed)


class StartSignal(NamedTuple):
    """A value to write to the start output: on, with the key of a step; or off (`key`: 0)."""

    is_on: bool
    key: int = 0


OFF = StartSignal(False)


@dataclass(frozen=True)
class HandOverMemory:
    """The stored data of a device. `lives`: how many drivers have started in this run."""

    run: int
    lives: int = 0
    last: int = 0
    steps: Tuple[ShownStep, ...] = ()
    phase: HandOverPhase = HandOverPhase.LEFT
    key: int = 0


@dataclass(frozen=True)
class HandOverMachine:
    """The device that the module describes. `now` is in s of a clock that never steps back.

    actor   -- the steps and their states, as they are reported to the fleet manager
    key     -- the key of the step that runs; 0: no step runs
    begun   -- number of exchanges that have begun
    is_awaited -- whether the last exchange has not ended
    begun_at -- when the last exchange began
    read_at -- when the last exchange with a reading began
    signals -- the newest reading; None: the last exchange had none
    alike   -- how many of the newest readings are equal and began in this phase, at most STEADY
    since   -- when the phase began
    phase_from -- number of exchanges that had begun when the phase began
    problem -- why the last exchange had no reading; empty: it had one

    It has many attributes because the phase follows from several facts of the last exchanges.
    """

    limits: DeviceLimits
    actor: ActorState
    lives: int
    phase: HandOverPhase
    key: int
    since: float
    begun: int = 0
    is_awaited: bool = False
    begun_at: float = 0.0
    read_at: Optional[float] = None
    signals: Optional[Signals] = None
    alike: int = 0
    phase_from: int = 0
    problem: str = ''

    @classmethod
    def start(cls, limits: DeviceLimits, memory: HandOverMemory, now: float) -> HandOverMachine:
        """Returns the device after a start with its stored memory.

        The caller must store the memory of the returned device, in which `lives` is larger by 1.
        """
        lives = memory.lives + 1
        actor = ActorState(memory.run, memory.last, memory.steps, lives * _REPORTS)
        return cls(limits, actor, lives, memory.phase, memory.key, now)

    @property
    def memory(self) -> HandOverMemory:
        """The data that must be stored before anything else happens."""
        return HandOverMemory(self.actor.run, self.lives, self.actor.last, self.actor.steps,
                              self.phase, self.key)

    @property
    def is_urgent(self) -> bool:
        """Whether the device answers, and no exchange has begun in this phase."""
        return not self.problem and self.phase in RUNNING and self.begun == self.phase_from

    # --- events -----------------------------------------------------------------------------------

    def obey(self, command: StepCommand, now: float) -> HandOverMachine:
        """Returns the device after a command.

        The caller must store `memory` before it does or reports anything.
        """
        actor, reaction = self.actor.obey(command)
        after = replace(self, actor=actor)
        if reaction is Reaction.BREAK_OFF and command.key == self.key:
            return after._break_off(now)
        if reaction is not Reaction.BEGIN:
            return after
        if self.phase in RUNNING:
            return after._refuse(command, StepCode.NOT_READY, 'another step runs there')
        if command.type != HAND_OVER:
            return after._refuse(command, StepCode.UNKNOWN_TYPE, f'a device does {HAND_OVER} only')
        if command.parameters:
            return after._refuse(command, StepCode.WRONG_PARAMETER, 'a device has no parameters')
        return replace(after, key=command.key)._enter(HandOverPhase.READYING, now)

    def begin(self, now: float) -> Tuple[HandOverMachine, Optional[StartSignal]]:
        """Returns the device at the beginning of an exchange, and the signal to write (None: none).

        The exchange before it must have ended. A changed `memory` must be stored before the
        exchange is carried out.
        """
        after, write = self, None
        if self.phase is HandOverPhase.READYING and self._is_steady():
            assert self.signals is not None
            if self._was_started():
                after = self._enter(HandOverPhase.WORKING, now)
            elif self.signals.are_off:
                after, write = self._enter(HandOverPhase.WORKING, now), StartSignal(True, self.key)
        if after is self and self._must_be_off():
            write = OFF
        return replace(after, begun=after.begun + 1, begun_at=now, is_awaited=True), write

    def end(self, signals: Optional[Signals], problem: str, now: float) -> HandOverMachine:
        """Returns the device after the end of the exchange.

        signals -- None: there was no reading, because of `problem`

        An exchange without a reading may have had an effect.
        """
        if signals is None:
            return replace(self, is_awaited=False, signals=None, alike=0,
                           problem=problem).tick(now)
        goes_on = self.alike and signals == self.signals
        alike = min(self.alike + 1, STEADY) if goes_on else 1
        if self.begun <= self.phase_from:
            alike = 0
        return replace(self, is_awaited=False, read_at=self.begun_at, signals=signals, alike=alike,
                       problem='')._judge(now).tick(now)

    def tick(self, now: float) -> HandOverMachine:
        """Returns the device after some time."""
        if self.phase not in RUNNING:
            return self
        read_at = self.since if self.read_at is None else max(self.read_at, self.since)
        if now - read_at > self.limits.offline_after:
            return self._give_up(StepCode.LOST_LINK, self.problem or 'it does not answer', now)
        if self.phase is not HandOverPhase.WORKING and now - self.since > self.limits.timeout:
            aim = 'get ready' if self.phase is HandOverPhase.READYING else 'break off'
            return self._give_up(StepCode.NOT_READY, f'it does not {aim} within '
                                 f'{self.limits.timeout:g} s: {self._readings()}', now)
        return self

    # --- rules ------------------------------------------------------------------------------------

    def _refuse(self, command: StepCommand, code: StepCode, text: str) -> HandOverMachine:
        return replace(self, actor=self.actor.end(command.key, Word.FAILED, code, text))

    def _break_off(self, now: float) -> HandOverMachine:
        if self.phase is HandOverPhase.READYING:
            return self._ended(Word.CANCELLED, StepCode.NONE, '', HandOverPhase.IDLE, now)
        return self if self.phase is HandOverPhase.BREAKING else self._enter(
            HandOverPhase.BREAKING, now)

    def _judge(self, now: float) -> HandOverMachine:
        """Returns the device after a reading, which may have ended the step."""
        if self.phase not in (HandOverPhase.WORKING, HandOverPhase.BREAKING) or (
                not self._is_steady()):
            return self
        signals = self.signals
        assert signals is not None
        if signals.key != self.key:
            return self._unknown('it does not show the key of the step', now)
        if self.phase is HandOverPhase.WORKING and not signals.start:
            return self._unknown('its start is off', now)
        if signals.done and signals.failed:
            return self._unknown('it says that it is done, and that it has failed', now)
        if signals.done:
            return self._ended(Word.DONE, StepCode.NONE, '', HandOverPhase.IDLE, now)
        if signals.failed:
            return self._ended(Word.FAILED, StepCode.OTHER, 'it says that it has failed',
                               HandOverPhase.IDLE, now)
        return self

    def _unknown(self, text: str, now: float) -> HandOverMachine:
        return self._ended(Word.UNKNOWN, StepCode.OTHER, text, HandOverPhase.LEFT, now)

    def _give_up(self, code: StepCode, text: str, now: float) -> HandOverMachine:
        """Returns the device after it has given up its step.

        A step that was never started has failed. The end of any other step is unknown.
        """
        word = Word.FAILED if self.phase is HandOverPhase.READYING else Word.UNKNOWN
        return self._ended(word, code, text, HandOverPhase.LEFT, now)

    def _ended(self, word: Word, code: StepCode, text: str, phase: HandOverPhase,
               now: float) -> HandOverMachine:
        actor = self.actor.end(self.key, word, code, text)
        return replace(self, actor=actor, key=0)._enter(phase, now)

    def _enter(self, phase: HandOverPhase, now: float) -> HandOverMachine:
        """Returns the device in a new phase, in which earlier readings do not count."""
        return replace(self, phase=phase, since=now, alike=0, phase_from=self.begun)

    def _is_steady(self) -> bool:
        return self.alike >= STEADY

    def _was_started(self) -> bool:
        """Returns whether the device shows that it was started with the key of this step."""
        return self.signals is not None and self.signals.start and self.signals.key == self.key

    def _must_be_off(self) -> bool:
        """Returns whether the start output must be switched off.

        If a step may be running, its output stays on.
        """
        if self.phase not in (HandOverPhase.IDLE, HandOverPhase.READYING, HandOverPhase.BREAKING):
            return False
        if self.phase is HandOverPhase.READYING and (self.signals is None or self._was_started()):
            return False
        return self.signals is None or self.signals.start

    def _readings(self) -> str:
        if self.signals is None or not self._is_steady():
            return 'its readings change'
        names = [name for name, is_on in (('start', self.signals.start),
                                          ('done', self.signals.done),
                                          ('failed', self.signals.failed)) if is_on]
        return f'{" and ".join(names)} {"are" if len(names) > 1 else "is"} on' if names else (
            'all signals are off')
