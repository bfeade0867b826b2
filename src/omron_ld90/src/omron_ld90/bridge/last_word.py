"""The last command for the robot, a drive or a stop, until its fate is known.

A command is given to the controller, which says how it ends. That answer may be lost, with a link,
the controller or a restart of this program. Or a drive was interrupted, cancelled or overruled.
Then `motion` says what became of it: the number and the fate of our last command.

    | the answer                        | what follows                                             |
    |-----------------------------------|----------------------------------------------------------|
    | it was never sent                 | it is given again, unless it is a stop that `motion`     |
    |                                   | tells                                                    |
    | lost; `motion` tells an older one | it is given again: the controller never had it; unless   |
    |                                   | it answered: then `motion` has still to tell             |
    | lost; `motion` tells a newer one  | this program forgot it, and decides anew where to drive  |
    | lost; NOT_OBEYED                  | a drive is given again: the robot does not carry it out  |
    | lost; COMPLETED, FAILED           | a drive has ended so                                     |
    | lost; any other                   | `motion` will say it                                     |
    | others ended a drive              | as if the answer was lost                                |
    | a stop that `motion` tells        | the controller has it, and sees to it                    |

If another giver did something, its epoch ends the route before anything is given again
(`RobotMonitor`).

A command that is given again gets a new number, so that the controller refuses the one before if it
still comes. Each command carries the epoch in which it is valid, so that a stop ends no newer drive
of another giver.
"""
from __future__ import annotations

import math
from typing import Optional, Tuple

from omron_arcl import Outcome
from omron_arcl.records import CommandFate
from omron_ld90.bridge.events import CommandEnded, Give

STOP = 'stop'
_TOLD_BY_MOTION = (Outcome.LOST, Outcome.INTERRUPTED, Outcome.CANCELLED, Outcome.OVERRULED)
RETRY = 1.0  # s between two attempts


class LastWord:
    """A command, until its fate is known. `epoch` is None for the present one."""

    def __init__(self, command: str = '', epoch: Optional[int] = None, number: int = 0) -> None:
        self.command, self.epoch = command, epoch
        self.number = number
        """Number under which it was given; 0: it was not given yet."""
        self.is_lost = bool(number)
        """Whether `motion` says what became of it, not the controller's answer."""
        self.must_be_given = bool(command) and not number
        self.is_taken = False
        """Whether the controller has it, for certain."""
        self.problem = ''
        """Why the last attempt failed."""
        self._was_tried = False
        self._not_before = -math.inf

    @property
    def is_stop(self) -> bool:
        """Whether it stops the robot."""
        return self.command == STOP

    def due(self, link_stands: bool, now: float) -> bool:
        """Returns whether to give it now; the first attempt is made regardless of the link."""
        return self.must_be_given and (
            not self._was_tried or link_stands and now >= self._not_before)

    def give(self, number: int, epoch: int) -> Give:
        """Gives it under this number; `epoch`: the present one."""
        self.number, self.must_be_given, self.is_lost = number, False, False
        self._was_tried = True
        return Give(number, self.command, epoch if self.epoch is None else self.epoch)

    def ended(self, event: CommandEnded, now: float) -> None:
        """Notes that the controller's answer came, or was lost."""
        if event.ending is Outcome.NEVER_SENT or self.is_stop and event.ending is Outcome.LOST:
            if not (self.is_stop and self.is_taken):  # else the controller sends it when it can
                self.give_again(now + RETRY)
            self.problem = event.text or event.ending.value
        elif not self.is_stop and event.ending in _TOLD_BY_MOTION:
            self.is_lost, self.is_taken = True, event.ending is not Outcome.LOST
        else:
            self.is_taken = True
            failed = event.ending is Outcome.FAILED
            self.problem = (event.text or event.ending.value) if failed else ''

    def give_again(self, not_before: float) -> None:
        """Notes that it must be given once more."""
        self.must_be_given, self.is_lost, self.is_taken, self._was_tried = True, False, False, True
        self._not_before = not_before

    def told(self, last: Tuple[int, Optional[CommandFate]], now: float) -> Optional[CommandFate]:
        """Returns how a lost drive has ended, as `motion` tells; None: it has not, or is not lost.

        last -- number and fate of our last command; None: nothing was told yet
        """
        number, fate = last
        if self.is_stop:
            self.is_taken = self.is_taken or 0 < self.number <= number
            self.must_be_given = self.must_be_given and not self.is_taken
        elif self.is_lost and fate is not None:
            if number < self.number and self.is_taken:
                return None
            if number < self.number or fate is CommandFate.NOT_OBEYED:
                self.give_again(now)
            elif fate in (CommandFate.COMPLETED, CommandFate.FAILED):
                self.is_lost = False
                return fate
        return None
