"""The size of the robot for which a graph is made and checked. Metres."""
from __future__ import annotations

import math
from dataclasses import dataclass

from graph_editor.errors import SiteError

NEARLY_STRAIGHT = math.radians(5.0)
"""Rad; at a smaller bend, a robot that drives straight on hardly leaves its path."""


@dataclass(frozen=True)
class RobotSize:
    """The size of a robot, and the width of its lanes.

    Raises SiteError for impossible numbers.
    """

    robot_width: float = 0.5
    robot_length: float = 0.7
    corridor: float = 0.9
    """The width of a lane if there is enough space."""

    def __post_init__(self) -> None:
        self._require('robot_width', 'robot_length', 'corridor')
        if self.corridor < self.robot_width:
            raise SiteError(f'A corridor of {self.corridor:g} m is too narrow for a robot '
                            f'{self.robot_width:g} m wide.')

    def _require(self, *names: str) -> None:
        """Raises SiteError if one of these attributes is not a possible size."""
        for name in names:
            value = getattr(self, name)
            if not 0.05 <= value <= 1000.0:
                raise SiteError(f'{name} is {value:g}, but must lie in 0.05..1000.')

    @property
    def half_diagonal(self) -> float:
        """The clearance that a robot needs to turn on the spot."""
        return math.hypot(self.robot_width, self.robot_length) / 2.0
