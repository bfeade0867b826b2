"""The limits for the checks of a graph. Metres."""
from __future__ import annotations

from dataclasses import dataclass

from graph_editor.robot import RobotSize


@dataclass(frozen=True)
class CheckRules(RobotSize):
    """The robot, its corridor, and further limits of edges and vertices."""

    least_radius: float = 0.3
    """A spline with a smaller radius is an error."""
    least_distance: float = 0.3
    """Robots cannot distinguish two vertices that are nearer to each other."""
    reach: float = 2.0
    """Floor with a greater driving distance from all edges is not served."""
    least_floor: float = 4.0
    """m2; a smaller area of unserved floor is not reported."""

    @property
    def turning(self) -> float:
        """The clearance that the robot needs to turn on the spot."""
        return self.half_diagonal
