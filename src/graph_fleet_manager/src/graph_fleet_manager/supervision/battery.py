"""What is known of a robot's battery, and what that is good for."""
from __future__ import annotations

import math

from graph_fleet_manager.supervision.liveness import Liveness
from graph_fleet_manager.supervision.settings import RobotSettings

MUTE = 60.0  # s without a word of the battery, of a robot that reports, after which it is unknown


class Battery:
    """A battery as its robot tells of it; times are those of the supervisor's clock.

    charge -- state of charge (0..1) as last told; NaN: never
    """

    def __init__(self, settings: RobotSettings) -> None:
        self.charge = math.nan
        self._settings = settings
        self._told = -math.inf

    def tell(self, charge: float, now: float) -> None:
        """The robot tells its state of charge, 0..1."""
        self.charge, self._told = charge, now

    def is_mute(self, liveness: Liveness, now: float) -> bool:
        """Is nothing heard of it any more although its robot reports?"""
        return now - max(self._told, liveness.since) > MUTE

    @property
    def is_low(self) -> bool:
        """Is it below the threshold? One that was never told of counts as full."""
        return self.charge < self._settings.charge_below

    @property
    def may_leave(self) -> bool:
        """Is it charged enough to leave the dock?"""
        return self.charge >= self._settings.leave_above

    @property
    def is_below_leaving(self) -> bool:
        """Is it known to be charged less than that?"""
        return self.charge < self._settings.leave_above

    def range_left(self) -> float:
        """How far (m) its robot may drive with what is left in it, the reserve aside."""
        if math.isnan(self.charge):
            return math.inf
        return max(self.charge - self._settings.reserve, 0.0) * self._settings.endurance
