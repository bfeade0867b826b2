"""The battery of one robot: its last reported charge, its thresholds, and the range left."""
from __future__ import annotations

import math

from fleet_core.supervision.liveness import Liveness
from fleet_core.supervision.settings import RobotSettings

# s: if a robot reports, but not its battery, its charge is unknown after this time
MUTE = 60.0


class Battery:
    """A battery as its robot reports it. Times are in s of the supervisor's clock.

    charge -- the last reported state of charge, from 0 to 1; NaN: never reported
    """

    def __init__(self, settings: RobotSettings) -> None:
        self.charge = math.nan
        self._settings = settings
        self._told = -math.inf

    def report(self, charge: float, now: float) -> None:
        """Notes that the robot has reported its state of charge, from 0 to 1."""
        self.charge, self._told = charge, now

    def is_mute(self, liveness: Liveness, now: float) -> bool:
        """Returns whether the robot still reports, but does not report its battery any more."""
        return now - max(self._told, liveness.since) > MUTE

    @property
    def is_low(self) -> bool:
        """Whether the charge is below the threshold.

        A battery that was never reported counts as full.
        """
        return self.charge < self._settings.charge_below

    @property
    def full(self) -> float:
        """The charge, from 0 to 1, with which the robot may leave the dock."""
        return self._settings.leave_above

    @property
    def may_leave(self) -> bool:
        """Whether the battery is charged enough to leave the dock."""
        return self.charge >= self._settings.leave_above

    @property
    def is_below_leaving(self) -> bool:
        """Whether the charge is known, and too low to leave the dock."""
        return self.charge < self._settings.leave_above

    @property
    def is_below_idle(self) -> bool:
        """Whether the charge is known and so low that the robot charges when it has nothing to do.
        """
        return self.charge < self._settings.idle_below

    def range_left(self) -> float:
        """Returns the distance (m) that the robot may drive before it needs its reserve."""
        if math.isnan(self.charge):
            return math.inf
        return max(self.charge - self._settings.reserve, 0.0) * self._settings.endurance
