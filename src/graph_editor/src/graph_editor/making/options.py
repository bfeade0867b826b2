"""What a made graph shall be like. Metres, m/s."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from graph_editor.errors import SiteError
from graph_editor.robot import RobotSize


class Halls(Enum):
    """How wide places are filled."""

    CENTRE = 'centre'
    """Lanes down the middle, and bays where the floor is far from them."""
    LATTICE = 'lattice'
    """Crossing lanes, `lattice_pitch` apart."""


@dataclass(frozen=True)
class MakingOptions(RobotSize):
    """How big the robot is, and what its lanes shall be like.

    Raises SiteError for numbers that fit no robot.
    """

    margin: float = 0.05
    """What stays free on either side of robot and corridor, and covers the grid's inaccuracy."""
    longest_edge: float = 5.0
    reach: float = 2.0
    """No reachable floor shall be farther from the lanes than this, by the way to drive."""
    speed: float = 1.0
    """On straight lanes in wide places; narrow places and bends are slower."""
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
        """The least clearance of a lane: where just the robot fits."""
        return self.robot_width / 2.0 + self.margin

    @property
    def wide(self) -> float:
        """The clearance of a lane with its whole corridor."""
        return self.corridor / 2.0 + self.margin

    @property
    def turning(self) -> float:
        """The clearance of a place where the robot can turn on the spot."""
        return self.half_diagonal + self.margin

    @property
    def least_turning(self) -> float:
        """The same where there is no better place: what a robot's search for a way needs."""
        return self.half_diagonal + self.margin / 4.0
