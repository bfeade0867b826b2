"""What a graph is measured by. Metres."""
from __future__ import annotations

from dataclasses import dataclass

from graph_editor.errors import SiteError


@dataclass(frozen=True)
class CheckRules:
    """The robot, its corridor, and what else edges and vertices shall keep.

    Raises SiteError for numbers that fit no robot.
    """

    robot_width: float = 0.5
    robot_length: float = 0.7
    corridor: float = 0.9
    least_radius: float = 0.3
    """A spline that bends more sharply is an error."""
    least_distance: float = 0.3
    """Two vertices nearer to each other are one place for robots."""
    reach: float = 2.0
    """Floor farther from all edges than this, by the way to drive, is not served."""
    least_floor: float = 4.0
    """m2 of floor that is not served, to be told."""

    def __post_init__(self) -> None:
        for name in ('robot_width', 'robot_length', 'corridor'):
            value = getattr(self, name)
            if not 0.05 <= value <= 1000.0:
                raise SiteError(f'{name} is {value:g}, but must lie in 0.05..1000 m.')

    @property
    def turning(self) -> float:
        """Half the robot's diagonal."""
        return (self.robot_width ** 2 + self.robot_length ** 2) ** 0.5 / 2.0
