"""A stop that is handed over to the controller, which sends it as soon as the robot can be reached.

That the controller is away, or its link broken, only delays it. Each attempt carries the epoch that
the stop is to end, so that it ends no newer drive of another giver.
"""
from __future__ import annotations

import math
from typing import Optional

from omron_ld90.bridge.events import CommandEnded, Ending

RETRY = 1.0  # s between two attempts that came to nothing

_NOT_TAKEN = (Ending.LOST, Ending.NEVER_SENT)


class StopDuty:
    """Whether a stop is to be handed over, and when to give it."""

    def __init__(self) -> None:
        self.owed_by_controller = False
        """Whether the controller says that the robot has not obeyed a stop yet."""
        self.problem = ''
        """Why the last attempt came to nothing."""
        self.forgive()

    @property
    def owed(self) -> bool:
        """Whether the robot may not have obeyed a stop of ours."""
        return self.to_give or bool(self.problem) and self.owed_by_controller

    def require(self, epoch: int) -> None:
        """The robot is to stop in what it does in this epoch; 0: in any case."""
        self.forgive()
        self.to_give, self.epoch = True, epoch

    def forgive(self) -> None:
        """No giver wants the stop any more, or none may give it."""
        self.to_give = False
        """Whether the controller has not taken it yet."""
        self.epoch = 0
        self.problem = ''
        self.number: Optional[int] = None  # of the attempt whose end is to come
        self._not_before = -math.inf

    def is_due(self, link_stands: bool, now: float) -> bool:
        """Whether to give the stop now; the first time regardless of the link."""
        if not self.to_give or self.number is not None:
            return False
        return self._not_before == -math.inf or (link_stands and now >= self._not_before)

    def given(self, number: int, now: float) -> None:
        """The stop was given as the command with this number."""
        self.number = number
        self._not_before = now + RETRY

    def ended(self, event: CommandEnded) -> None:
        """A command has ended, perhaps the stop."""
        if self.to_give and event.number == self.number:
            self.number = None
            if event.ending in _NOT_TAKEN:
                self.problem = event.text or event.ending.value
            else:
                self.to_give = False
                self.problem = (event.text or event.ending.value
                                if event.ending is Ending.FAILED else '')
