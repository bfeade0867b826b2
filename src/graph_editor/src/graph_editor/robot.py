"""The robot that a graph is made for and checked with. Metres."""
from __future__ import annotations

import math
from dataclasses import dataclass

from graph_editor.errors import SiteError

NEARLY_STRAIGHT = math.radians(5.0)
"""A robot that drives straight on where its way bends by less hardly leaves it."""


@dataclass(frozen=True)
class RobotSize:
    """How big a robot is, and what it shall have free on its way.

    Raises SiteError for numbers that fit no robot.
    """

    robot_width: float = 0.5
    robot_length: float = 0.7
    corridor: float = 0.9
    """Floor that a lane gets where there is room for it."""

    def __post_init__(self) -> None:
        self._require('robot_width', 'robot_length', 'corridor')
        if self.corridor < self.robot_width:
            raise SiteError(f'A corridor of {self.corridor:g} m is of no use to a robot '
                            f'{self.robot_width:g} m wide.')

    def _require(self, *names: str) -> None:
        """These must be sizes of a robot or its site."""
        for name in names:
            value = getattr(self, name)
            if not 0.05 <= value <= 1000.0:
                raise SiteError(f'{name} is {value:g}, but must lie in 0.05..1000.')

    @property
    def half_diagonal(self) -> float:
        """What a robot needs around it to turn on the spot."""
        return math.hypot(self.robot_width, self.robot_length) / 2.0
