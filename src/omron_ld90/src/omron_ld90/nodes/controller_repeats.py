"""Recognises a drive that is given again while the robot obeys it.

Programs publish the same goal again and again, some five times a second. If each became a command,
the robot would be interrupted each time, and would need three times as long.
"""
from __future__ import annotations

from typing import Optional

from omron_arcl import Execution, Giver
from omron_arcl.commands import Category

_HARMLESS = (Category.QUERY, Category.DEVICE)


class ObeyedDrive:
    """The newest drive of this node that ends at a place, until something else moves the robot.

    Relative moves are not included: a `move` given twice is meant twice.
    """

    def __init__(self) -> None:
        self._newest: Optional[Execution] = None

    def given(self, execution: Execution) -> None:
        """Takes each command that is given to the robot; all that may move or stop it counts."""
        if execution.command.spec.category not in _HARMLESS:
            self._newest = execution

    def same_as(self, text: str, giver: Giver, known_epoch: int = 0) -> Optional[Execution]:
        """Returns the drive that this command of this giver would only repeat, or None.

        Another giver's command is never a repetition: it may take the robot over.
        """
        drive = self._newest
        if drive is None or not drive.command.spec.may_repeat:
            return None
        is_over = drive.result is not None or drive.progress.cancel_requested is not None
        is_same = (drive.command.text, drive.giver, drive.known_epoch) == (
            text.strip(' '), giver, known_epoch)
        return drive if is_same and not is_over else None
