"""The last line of the start of one robot: it is ready, and what a person can do now."""
from __future__ import annotations

import shlex
from contextlib import suppress
from enum import Enum
from typing import Optional, Sequence

from omron_arcl import InvalidCommand
from omron_ld90.operator.goal_clicks import Target, TargetKind


class Advice(Enum):
    """What a person can do when the robot is ready, besides a click."""

    COMMAND = 'command'
    """Publish a command."""
    MISSION = 'mission'
    """Send a mission: a fleet manager drives the robot."""
    NOTHING = 'nothing'
    """No advice, because another node gives it."""


class ReadyNotice:
    """Says once, when a map is displayed and the robot is connected, that a click drives the robot.
    """

    def __init__(self, robot: str, advice: Advice = Advice.COMMAND) -> None:
        """robot -- the robot's namespace"""
        self._robot, self._advice = robot, advice
        self._is_said = advice is Advice.NOTHING

    def words(self, targets: Optional[Sequence[Target]], is_connected: bool) -> str:
        """Returns the sentences. Empty: they were returned before, or the robot is not ready.

        targets -- goals and docks of the displayed map; None: no map is displayed
        """
        if self._is_said or not targets or not is_connected:
            return ''
        self._is_said = True
        return f'Ready: {self._robot}. Click a goal in RViz, or {self._other_way(targets)}'

    def _other_way(self, targets: Sequence[Target]) -> str:
        if self._advice is Advice.MISSION:
            return ('send a mission to a vertex: rosrun graph_fleet_manager mission '
                    f'{_vertex(targets)} --robot {self._robot}')
        return (f'publish a command: rostopic pub -1 /{self._robot}/send_command std_msgs/String '
                f'{shlex.quote(_example(targets))}')


def _vertex(targets: Sequence[Target]) -> str:
    """Returns the name of the first goal that is a vertex."""
    return next((target.name for target in _goals_first(targets) if target.name.isdecimal()),
                'VERTEX')


def _example(targets: Sequence[Target]) -> str:
    """Returns the command for the first goal that a command can name, otherwise `stop`."""
    for target in _goals_first(targets):
        with suppress(InvalidCommand):
            return target.command
    return 'stop'


def _goals_first(targets: Sequence[Target]) -> Sequence[Target]:
    """Returns the targets with the docks last: at the start, a robot often stands in its dock."""
    return sorted(targets, key=lambda one: one.kind is TargetKind.DOCK)
