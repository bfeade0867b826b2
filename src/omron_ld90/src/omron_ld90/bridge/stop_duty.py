"""A stop that is owed until the robot has obeyed it or somebody else drives it.

A broken link, a full queue, a refusal or a restart of a node only delays it.
"""
from __future__ import annotations

import math
from typing import Optional

from omron_ld90.bridge.events import CommandEnded, Ending, Motion, RobotSeen

RETRY = 1.0       # s between two attempts that came to nothing
STATUS_LAG = 1.0  # s that a status may be older than what the robot was told

_AT_REST = (Motion.STANDING, Motion.ARRIVED, Motion.FAILED, Motion.DOCKED)
_OVER = (Ending.SUCCEEDED, Ending.INTERRUPTED, Ending.EMERGENCY_STOPPED)


class StopDuty:
    """Whether a stop is owed, and when to give it."""

    def __init__(self) -> None:
        self.forgive()

    def require(self, now: float, look_first: float = 0.0) -> None:
        """The robot is to stop; `look_first` s are given to its status to show that it is needed.

        That is for a stop whose cause is not of this moment: somebody else may drive by now.
        """
        self.forgive()
        self.owed = True
        self._since = now
        self._look_until = now + look_first

    def forgive(self) -> None:
        """Nobody wants the stop any more, or nobody may give it."""
        self.owed = False
        self.problem = ''
        """Why the last attempt came to nothing."""
        self.number: Optional[int] = None  # of the attempt whose end is to come
        self._since = -math.inf
        self._not_before = -math.inf
        self._seen_over = False
        self._look_until = -math.inf  # so long the robot's status is awaited before the stop

    def is_due(self, link_stands: bool, now: float) -> bool:
        """Whether to give the stop now; the first time whatever is known of the link."""
        if not self.owed or self.number is not None or now < self._look_until:
            return False
        return self._not_before == -math.inf or (link_stands and now >= self._not_before)

    def given(self, number: int, now: float) -> None:
        """The stop was given as the command with this number."""
        self.number = number
        self._not_before = now + RETRY

    def ended(self, event: CommandEnded) -> None:
        """A command has ended, perhaps the stop."""
        if self.owed and event.number == self.number:
            self.number = None
            self.problem = event.text or event.ending.value
            if event.ending in _OVER:
                self.forgive()

    def seen(self, status: RobotSeen, on_our_way: Optional[bool], now: float) -> None:
        """The robot's status: twice at rest, or on another way than ours, ends the duty.

        `on_our_way` is None where the robot is not seen to go anywhere.
        """
        if not self.owed or now < self._since + STATUS_LAG:
            return
        if on_our_way:
            self._look_until = now
        over = status.motion in _AT_REST or on_our_way is False
        if over and self._seen_over:
            self.forgive()
        else:
            self._seen_over = over
