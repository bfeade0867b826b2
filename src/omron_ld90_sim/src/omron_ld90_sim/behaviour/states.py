"""States of the robot, and what its activities are made of."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Generator, Optional, Tuple, Union


class DockingState(Enum):
    """The DockingState field of a DockingState line."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


class Motors(Enum):
    """Whether the robot can drive, in the words of `queryMotors`."""

    ENABLED = 'Motors enabled'
    DISABLED = 'Motors disabled'
    ESTOP = 'EStop pressed'
    RELIEVED = 'EStop relieved but motors still disabled'


class InterruptedWords(Enum):
    """What the `Interrupted:` line says of a drive to a goal that something ended."""

    NAME = 'name'                   # the goal's name (ARCL manual I617-E-01 p. 242)
    COORDINATES = 'coordinates'     # where the goal is (I617-E-02 p. 243)
    NOTHING = 'nothing'             # there is no such line


class Failure(Exception):
    """An activity cannot go on: the `Error:` text, and the status that remains."""

    def __init__(self, text: str, status: str) -> None:
        super().__init__(text)
        self.status = status


class Standing:
    """What an activity yields to wait until the base stands."""


STANDING = Standing()
Script = Generator[Union[float, Standing], None, None]


@dataclass
class Activity:
    """Something the robot is doing."""

    status: str         # the Status text while it runs
    extended: str
    script: Script
    point: Optional[Tuple[float, float]] = None     # mm, where it drives to
    goal: bool = False                              # that is a goal, whose name stands in status

    def interrupted(self, words: InterruptedWords) -> Optional[str]:
        """What is told of its early end, if anything; a point has no name but its place."""
        if words is InterruptedWords.NOTHING:
            return None
        if self.point is None or (self.goal and words is InterruptedWords.NAME):
            return f'Interrupted: {self.status}'
        x, y = self.point
        return f'Interrupted: Going to {x:.0f} {y:.0f}'
