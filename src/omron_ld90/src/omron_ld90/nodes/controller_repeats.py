"""Recognises a drive that is given again while the robot obeys it.

Some programs publish the same goal five times a second. If each message became a command, it would
interrupt the robot, and the drive would take three times as long.
"""
from __future__ import annotations

from typing import Optional

from omron_arcl import Execution, Giver
from omron_arcl.commands import Category

_HARMLESS = (Category.QUERY, Category.DEVICE)


class ObeyedDrive:
    """The newest command of this node that may move or stop the robot.

    Only a drive to a place can be repeated without effect. A relative `move` that is given twice is
    meant twice.
    """

    def __init__(self) -> None:
        self._newest: Optional[Execution] = None

    def given(self, execution: Execution) -> None:
        """Takes a command that is given to the robot. Queries and device commands do not count."""
        if execution.command.spec.category not in _HARMLESS:
            self._newest = execution

    def same_as(self, text: str, giver: Giver, known_epoch: int = 0) -> Optional[Execution]:
        """Returns the drive that this command of this giver would only repeat, or None.

        The command of another giver is never a repetition, because it may take over the robot.
        """
        drive = self._newest
        if drive is None or not drive.command.spec.may_repeat:
            return None
        is_over = drive.result is not None or drive.progress.cancel_requested is not None
        is_same = (drive.command.text, drive.giver, drive.known_epoch) == (
            text.strip(' '), giver, known_epoch)
        return drive if is_same and not is_over else None
