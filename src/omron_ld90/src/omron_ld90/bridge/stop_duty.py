"""A stop that is given to the controller, which sends it as soon as the robot can be reached.

If the controller is gone, or its link is broken, the stop is only delayed. Each attempt carries the
epoch that the stop must end, so that it ends no newer drive of another giver.
"""
from __future__ import annotations

import math
from typing import Optional

from omron_ld90.bridge.events import CommandEnded, Ending

RETRY = 1.0  # s between two failed attempts

_NOT_TAKEN = (Ending.LOST, Ending.NEVER_SENT)


class StopDuty:
    """Knows whether a stop must be given to the controller, and when."""

    def __init__(self) -> None:
        self.owed_by_controller = False
        """Whether the controller reports that the robot has not obeyed a stop yet."""
        self.problem = ''
        """Why the last attempt failed."""
        self.forgive()

    @property
    def owed(self) -> bool:
        """Whether the robot may not have obeyed a stop of ours."""
        return self.to_give or bool(self.problem) and self.owed_by_controller

    def require(self, epoch: int) -> None:
        """Requires a stop of the motion of this epoch; 0: of any epoch."""
        self.forgive()
        self.to_give, self.epoch = True, epoch

    def forgive(self) -> None:
        """Drops the stop: it is not wanted any more, or may not be given any more."""
        self.to_give = False
        """Whether the controller has not accepted the stop yet."""
        self.epoch = 0
        self.problem = ''
        self.number: Optional[int] = None  # of the attempt whose end is awaited
        self._not_before = -math.inf

    def is_due(self, link_stands: bool, now: float) -> bool:
        """Whether to give the stop now; the first attempt is made regardless of the link."""
        if not self.to_give or self.number is not None:
            return False
        return self._not_before == -math.inf or (link_stands and now >= self._not_before)

    def given(self, number: int, now: float) -> None:
        """The stop was given as the command with this number."""
        self.number = number
        self._not_before = now + RETRY

    def ended(self, event: CommandEnded) -> None:
        """Takes the end of a command, which may be the stop."""
        if self.to_give and event.number == self.number:
            self.number = None
            if event.ending in _NOT_TAKEN:
                self.problem = event.text or event.ending.value
            else:
                self.to_give = False
                self.problem = (event.text or event.ending.value
                                if event.ending is Ending.FAILED else '')
