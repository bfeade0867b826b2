"""States of the robot, and the parts of its activities."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Generator, Optional, Tuple, Union


class DockingPhase(Enum):
    """The DockingState field of a DockingState line."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


class MotorState(Enum):
    """The state of the motors. The values are the answers of `queryMotors`."""

    ENABLED = 'Motors enabled'
    DISABLED = 'Motors disabled'
    ESTOP = 'EStop pressed'
    RELIEVED = 'EStop relieved but motors still disabled'


class InterruptedWords(Enum):
    """The content of the `Interrupted:` line after a drive to a goal was ended."""

    NAME = 'name'                   # the goal's name (ARCL manual I617-E-01 p. 242)
    COORDINATES = 'coordinates'     # the goal's coordinates (I617-E-02 p. 243)
    NOTHING = 'nothing'             # no such line is sent


class ActivityFailure(Exception):
    """An activity failed. The error has the text of the `Error:` line, and the status to show."""

    def __init__(self, text: str, status: str) -> None:
        super().__init__(text)
        self.status = status


class Standing:
    """The value that an activity yields to wait until the base stands."""


STANDING = Standing()
Script = Generator[Union[float, Standing], None, None]


@dataclass
class ScriptedActivity:
    """An activity of the robot."""

    status: str         # the Status text during the activity
    extended: str
    script: Script
    point: Optional[Tuple[float, float]] = None     # mm, its destination
    goal: bool = False                              # whether `point` is a goal; `status` names it

    def interrupted(self, words: InterruptedWords) -> Optional[str]:
        """Returns the line that announces the early end of the activity; None: there is no line.

        A drive to a point is announced with coordinates, because a point has no name.
        """
        if words is InterruptedWords.NOTHING:
            return None
        if self.point is None or (self.goal and words is InterruptedWords.NAME):
            return f'Interrupted: {self.status}'
        x, y = self.point
        return f'Interrupted: Going to {x:.0f} {y:.0f}'
