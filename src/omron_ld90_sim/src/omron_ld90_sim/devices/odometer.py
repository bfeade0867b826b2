"""The trip odometer."""
from __future__ import annotations

from typing import Tuple

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.motion.base import Base


class SimOdometer:
    """Distance, rotation and time since its last reset."""

    def __init__(self, base: Base, clock: SimClock) -> None:
        self._base, self._clock = base, clock
        self.reset()

    def reset(self) -> None:
        """Resets all values to zero."""
        self._zero = self._total()

    @property
    def trip(self) -> Tuple[float, float, float]:
        """Millimetres, degrees and seconds."""
        driven, turned, time = (now - zero for now, zero in zip(self._total(), self._zero))
        return driven, turned, time

    def _total(self) -> Tuple[float, float, float]:
        return self._base.driven, self._base.turned, self._clock.now
