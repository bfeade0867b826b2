"""Steps: all work of a robot except driving, as the master orders it and the robot shows it.

A device that hands over to robots carries out steps in the same way: it is then the "robot" below.

A master orders a step with a command that has a *key*. Keys only grow, even after a restart of the
master. The robot takes each key once: if the key of a command is not above the last key, the
command is a repetition. So a master repeats a command until the robot shows its key, and the step
is carried out at most once. The master sends the command with the next key only when the robot
shows the previous key.

The robot draws a number, its *run*, when it starts, and shows it. A command names the run that the
master knows. If the robot has started again since then, it does not obey the command, because it
does not know whether it has carried out this step already.

    | command                            | the robot                                    |
    |------------------------------------|----------------------------------------------|
    | any, for another run               | ignores it                                   |
    | DO, key above the last             | begins the step, and shows it RUNNING        |
    | DO, any other key                  | ignores it: it has taken the key before      |
    | CANCEL, REVOKE, key above the last | shows it CANCELLED, and never begins it      |
    | CANCEL of a step that is RUNNING   | ends it if it can, or goes on with it        |
    | any other CANCEL or REVOKE         | ignores it                                   |
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import NamedTuple, Optional, Tuple

KEPT = 20  # number of ended steps that a robot shows
HAND_OVER = 'handshake'  # the type of the steps that a device carries out
MOST_KEY = 2 ** 53 - 1  # the highest key that all readers of messages and of JSON can hold


class StepAct(IntEnum):
    """What a robot must do with a step, as in itrci_nav_msgs/StepCommand."""

    DO = 0
    CANCEL = 1   # end it, or never begin it
    REVOKE = 2   # never begin it; if it has begun, go on


class Word(IntEnum):
    """The state of a step as its robot shows it, as in itrci_nav_msgs/StepState.

    FAILED and CANCELLED also mean that no load was taken or given.
    """

    RUNNING = 0
    DONE = 1
    FAILED = 2
    CANCELLED = 3
    UNKNOWN = 4  # the step has ended, and the robot does not know how

    @property
    def is_final(self) -> bool:
        """Whether the step has ended."""
        return self is not Word.RUNNING


class StepCode(IntEnum):
    """Why a step has not been done, as in itrci_nav_msgs/StepState."""

    NONE = 0
    OTHER = 1
    UNKNOWN_TYPE = 2      # the robot has no step of this type
    WRONG_PARAMETER = 3
    NOT_READY = 4         # the robot could not begin the step
    LOST_LINK = 5         # the robot's driver has lost the robot


@dataclass(frozen=True)
class StepCommand:
    """A command for one step.

    known_run  -- the robot's run, as the master knows it
    type       -- name of the kind of work; empty for commands other than DO
    parameters -- names and values
    timeout    -- s that the master waits for the end of the step
    """

    key: int
    act: StepAct
    known_run: int
    type: str = ''
    parameters: Tuple[Tuple[str, str], ...] = ()
    timeout: float = 0.0


@dataclass(frozen=True)
class ShownStep:
    """A step that a robot has taken, as the robot shows it. `text` is for people."""

    key: int
    word: Word = Word.RUNNING
    code: StepCode = StepCode.NONE
    text: str = ''


class StepReport(NamedTuple):
    """What a robot shows of all its steps.

    run    -- number that the robot drew when it started; a later run has a higher number
    number -- grows with each report of a run
    last   -- the highest key that the robot has taken in this run; 0: none
    """

    run: int
    number: int = 0
    last: int = 0
    steps: Tuple[ShownStep, ...] = ()

    def find(self, key: int) -> Optional[ShownStep]:
        """Returns the step with this key; None: the report does not show it."""
        return next((step for step in self.steps if step.key == key), None)

    def is_newer_than(self, other: Optional[StepReport]) -> bool:
        """Returns whether this report was made later than the other one."""
        return other is None or (self.run, self.number) > (other.run, other.number)


class Reaction(Enum):
    """What a robot has to do because of a command."""

    NOTHING = 'nothing'
    BEGIN = 'begin the step'
    BREAK_OFF = 'end the step if that is possible'


@dataclass(frozen=True)
class ActorState:
    """A robot's memory of its steps; the methods follow the table in the module's docstring."""

    run: int
    last: int = 0
    steps: Tuple[ShownStep, ...] = ()
    number: int = 0

    def obey(self, command: StepCommand) -> Tuple[ActorState, Reaction]:
        """Returns the memory after a command, and what the robot has to do."""
        if command.known_run != self.run:
            return self, Reaction.NOTHING
        if command.key > self.last:
            is_begun = command.act is StepAct.DO
            step = ShownStep(command.key, Word.RUNNING if is_begun else Word.CANCELLED)
            return (replace(self, last=command.key, steps=_kept((*self.steps, step))),
                    Reaction.BEGIN if is_begun else Reaction.NOTHING)
        running = any(step.key == command.key and not step.word.is_final for step in self.steps)
        breaks = running and command.act is StepAct.CANCEL
        return self, Reaction.BREAK_OFF if breaks else Reaction.NOTHING

    def end(self, key: int, word: Word, code: StepCode = StepCode.NONE,
            text: str = '') -> ActorState:
        """Returns the memory after a running step has ended.

        A step that has ended does not change.
        """
        return replace(self, steps=tuple(
            ShownStep(key, word, code, text) if step.key == key and not step.word.is_final
            else step for step in self.steps))

    def report(self) -> Tuple[ActorState, StepReport]:
        """Returns the memory after the next report, and this report."""
        after = replace(self, number=self.number + 1)
        return after, StepReport(self.run, after.number, self.last, self.steps)


def _kept(steps: Tuple[ShownStep, ...]) -> Tuple[ShownStep, ...]:
    """Returns all running steps, and the last KEPT steps that have ended."""
    ended = [step for step in steps if step.word.is_final][-KEPT:]
    return tuple(step for step in steps if not step.word.is_final or step in ended)
