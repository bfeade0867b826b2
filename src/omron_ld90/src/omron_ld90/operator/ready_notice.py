"""The last line of the start of one robot: it is ready, and what a person can do now."""
from __future__ import annotations

import shlex
from contextlib import suppress
from typing import Optional, Sequence

from omron_arcl import InvalidCommand
from omron_ld90.operator.goal_clicks import Target, TargetKind


class ReadyNotice:
    """Says once that a click drives the robot: a map is displayed, and the robot is reached."""

    def __init__(self, robot: str) -> None:
        """robot -- its namespace"""
        self._robot, self._is_said = robot, False

    def words(self, targets: Optional[Sequence[Target]], is_connected: bool) -> str:
        """Returns the sentences; empty: they are said already, or the robot is not ready.

        targets -- goals and docks of the displayed map; None: no map is displayed
        """
        if self._is_said or not targets or not is_connected:
            return ''
        self._is_said = True
        return (f'Ready: {self._robot}. Click a goal in RViz, or publish a command: '
                f'rostopic pub -1 /{self._robot}/send_command std_msgs/String '
                f'{shlex.quote(_example(targets))}')


def _example(targets: Sequence[Target]) -> str:
    """Returns the command for the first goal that a command can name; else one that names none.

    At the start a robot often stands in its dock.
    """
    for target in sorted(targets, key=lambda one: one.kind is TargetKind.DOCK):
        with suppress(InvalidCommand):
            return target.command
    return 'stop'
