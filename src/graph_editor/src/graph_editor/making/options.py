"""The requirements for a made graph. Metres, m/s."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from graph_editor.errors import SiteError
from graph_editor.robot import RobotSize


class Halls(Enum):
    """The kind of lanes in wide places."""

    CENTRE = 'centre'
    """Lanes in the middle, and bays into floor that is far from these lanes."""
    LATTICE = 'lattice'
    """Crossing lanes with the distance `lattice_pitch`."""


@dataclass(frozen=True)
class MakingOptions(RobotSize):
    """The size of the robot, and the requirements for its lanes.

    Raises SiteError for impossible numbers.
    """

    margin: float = 0.05
    """Free space on each side of robot and corridor; covers the inaccuracy of the grid."""
    longest_edge: float = 5.0
    reach: float = 2.0
    """The largest driving distance that reachable floor may have from the lanes."""
    speed: float = 1.0
    """The speed on straight lanes in wide places. In narrow places and bends the speed is lower."""
    halls: Halls = Halls.CENTRE
    lattice_pitch: float = 3.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._require('longest_edge', 'reach', 'speed', 'lattice_pitch')
        if not 0.0 <= self.margin <= 1.0:
            raise SiteError(f'margin is {self.margin:g}, but must lie in 0..1 m.')
        if self.lattice_pitch < self.corridor:
            raise SiteError(f'Lanes {self.lattice_pitch:g} m apart leave no corridor of '
                            f'{self.corridor:g} m.')

    @property
    def tight(self) -> float:
        """The smallest clearance of a lane: just enough for the robot to drive."""
        return self.robot_width / 2.0 + self.margin

    @property
    def wide(self) -> float:
        """The clearance of a lane with its whole corridor."""
        return self.corridor / 2.0 + self.margin

    @property
    def turning(self) -> float:
        """The clearance of a place at which the robot can turn on the spot."""
        return self.half_diagonal + self.margin

    @property
    def least_turning(self) -> float:
        """The smallest clearance for turning, used if there is no better place: a robot's own path
        search needs this much.
        """
        return self.half_diagonal + self.margin / 4.0
