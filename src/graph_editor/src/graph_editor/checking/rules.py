"""What a graph is measured by. Metres."""
from __future__ import annotations

from dataclasses import dataclass

from graph_editor.robot import RobotSize


@dataclass(frozen=True)
class CheckRules(RobotSize):
    """The robot, its corridor, and what else edges and vertices shall keep."""

    least_radius: float = 0.3
    """A spline that bends more sharply is an error."""
    least_distance: float = 0.3
    """Two vertices nearer to each other are one place for robots."""
    reach: float = 2.0
    """Floor farther from all edges than this, by the way to drive, is not served."""
    least_floor: float = 4.0
    """m2 of floor that is not served, to be told."""

    @property
    def turning(self) -> float:
        """The clearance of a place where the robot can turn on the spot."""
        return self.half_diagonal
