"""States of the robot, and what its activities are made of."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Generator, Union


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

    status: str         # the Status text while it runs, and the text behind `Interrupted:`
    extended: str
    script: Script
