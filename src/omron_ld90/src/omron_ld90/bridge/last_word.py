"""The last command for the robot, a drive or a stop, until its fate is known.

A command is given to the controller, which answers how the command ends. The answer may be lost
with a link, with the controller, or by a restart of this program. Or the answer says that a drive
was interrupted, cancelled or overruled; this counts as a lost answer. In both cases `motion` shows
the fate: it contains the number and the fate of our last command that the controller has.

    | the answer                        | what follows                                             |
    |-----------------------------------|----------------------------------------------------------|
    | the command was never sent; or    | the command is given again, unless it is a stop whose    |
    | the answer to a stop is lost      | number `motion` has shown                                |
    | lost; `motion` has an older       | the command is given again, because the controller never |
    | number                            | had it; but if an answer has come that counts as lost,   |
    |                                   | `motion` will show the fate of the command               |
    | lost; `motion` has a newer number | this program had forgotten the newer command, and        |
    |                                   | decides anew where to drive                              |
    | lost; `motion` has NOT_OBEYED     | the drive is given again: the robot does not carry it out|
    | lost; COMPLETED or FAILED         | this is how the drive has ended                          |
    | lost; any other fate              | `motion` will show the end                               |
    | any answer to a stop whose number | the controller has the stop, and sends it until the      |
    | `motion` has shown                | robot obeys                                              |

If another giver has acted, its epoch ends the route before any command is given again
(`RobotMonitor`).

A command that is given again gets a new number. So the controller refuses the command with the old
number if it arrives late. Each command carries the epoch in which it is valid, so that a stop ends
no newer drive of another giver.
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
    """A command, until its fate is known.

    epoch -- the epoch in which the command is valid; None: the epoch in which it is given
    """

    def __init__(self, command: str = '', epoch: Optional[int] = None, number: int = 0) -> None:
        self.command, self.epoch = command, epoch
        self.number = number
        """The number with which it was given; 0: it was not given yet."""
        self.is_lost = bool(number)
        """Whether its fate will come from `motion`, not from the controller's answer."""
        self.must_be_given = bool(command) and not number
        self.is_taken = False
        """Whether the controller certainly has the command."""
        self.problem = ''
        """Why the last attempt failed."""
        self._was_tried = False
        self._not_before = -math.inf

    @property
    def is_stop(self) -> bool:
        """Whether the command is a stop."""
        return self.command == STOP

    def due(self, link_stands: bool, now: float) -> bool:
        """Returns whether to give the command now. The first attempt needs no link."""
        return self.must_be_given and (
            not self._was_tried or link_stands and now >= self._not_before)

    def give(self, number: int, epoch: int) -> Give:
        """Gives the command with this number. epoch -- the present epoch"""
        self.number, self.must_be_given, self.is_lost = number, False, False
        self._was_tried = True
        return Give(number, self.command, epoch if self.epoch is None else self.epoch)

    def ended(self, event: CommandEnded, now: float) -> None:
        """Notes that the controller's answer came, or was lost."""
        if event.ending is Outcome.NEVER_SENT or self.is_stop and event.ending is Outcome.LOST:
            if not (self.is_stop and self.is_taken):  # the controller sends a taken stop
                self.give_again(now + RETRY)
            self.problem = event.text or event.ending.value
        elif not self.is_stop and event.ending in _TOLD_BY_MOTION:
            self.is_lost, self.is_taken = True, event.ending is not Outcome.LOST
        else:
            self.is_taken = True
            failed = event.ending is Outcome.FAILED
            self.problem = (event.text or event.ending.value) if failed else ''

    def give_again(self, not_before: float) -> None:
        """Notes that the command must be given again, not before the time `not_before`."""
        self.must_be_given, self.is_lost, self.is_taken, self._was_tried = True, False, False, True
        self._not_before = not_before

    def told(self, last: Tuple[int, Optional[CommandFate]], now: float) -> Optional[CommandFate]:
        """Returns how a lost drive has ended according to `motion`; None: not yet, or not lost.

        last -- number and fate of our last command that the controller has; fate None: unknown
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
