"""The pose that the robot believes, and its localization score."""
from __future__ import annotations

from typing import Tuple

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.motion.kinematics import SimPose, normalise
from omron_ld90_sim.motion.noise import noise

FOUND_WITHIN = (1000.0, 30.0)   # mm, deg: a search that begins within this error succeeds
SCORE_FOUND, SCORE_LOST = 0.87, 0.06
SCORE_NOISE = 0.012             # standard deviation

_NO_ERROR = SimPose(0.0, 0.0, 0.0)


class Localization:
    """The pose that a robot believes: its true pose plus `error`; 0: the robot is not lost."""

    def __init__(self, clock: SimClock, seed: int) -> None:
        self.error = _NO_ERROR
        self._clock, self._seed = clock, seed

    @property
    def lost(self) -> bool:
        """Whether the believed pose is wrong."""
        return self.error != _NO_ERROR

    def believed(self, true: SimPose) -> SimPose:
        """Returns the believed pose of a robot whose true pose is `true`."""
        return SimPose(true.x + self.error.x, true.y + self.error.y,
                       normalise(true.theta + self.error.theta))

    def search(self, around: SimPose, true: SimPose, spread: Tuple[float, float]) -> None:
        """Searches within `spread` (mm, deg) of a pose. If the true pose is elsewhere, the robot is
        lost.
        """
        off = true.distance_to(around.x, around.y)
        turned = normalise(around.theta - true.theta)
        if off <= spread[0] and abs(turned) <= spread[1]:
            self.error = _NO_ERROR
        else:
            self.error = SimPose(around.x - true.x, around.y - true.y, turned)

    @property
    def score(self) -> float:
        """How well the laser scan fits the map at the believed pose, 0 to 1; with noise."""
        fit = SCORE_LOST if self.lost else SCORE_FOUND
        error = noise(self._seed, self._clock.now, SCORE_NOISE, 1)[0]
        return float(min(max(fit + error, 0.0), 1.0))
