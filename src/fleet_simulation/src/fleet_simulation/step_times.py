"""How long simulated steps and devices take."""
from __future__ import annotations

from dataclasses import dataclass, field
from random import Random
from typing import Mapping, Optional, Tuple

DEVICE_SECONDS = 2.0  # s; time to open or close a device for which the demand file gives none


@dataclass(frozen=True)
class Duration:
    """A duration that is drawn between (1 - scatter) and (1 + scatter) times `seconds`.

    scatter -- 0..1
    """

    seconds: float
    scatter: float = 0.0

    @property
    def longest(self) -> float:
        """The longest duration that can be drawn, in s."""
        return self.seconds * (1.0 + self.scatter)

    def draw(self, random: Random) -> float:
        """Draws a duration, in s."""
        return self.seconds * random.uniform(1.0 - self.scatter, 1.0 + self.scatter)


@dataclass(frozen=True)
class WorkTimes:
    """The durations of steps and devices that a demand file gives.

    steps   -- durations by the type of the step and its station or vertex ('': everywhere)
    devices -- s that each device takes to open or to close, by its name
    """

    steps: Mapping[Tuple[str, str], Duration] = field(default_factory=dict)
    devices: Mapping[str, float] = field(default_factory=dict)

    def of_step(self, type: str, station: str, vertex: int) -> Optional[Duration]:
        """Returns the duration for the vertex, otherwise for the station, otherwise for all places.

        None: the file gives none of these durations.
        """
        for at in (str(vertex), station, ''):
            if (type, at) in self.steps:
                return self.steps[type, at]
        return None

    def of_device(self, name: str) -> float:
        """Returns the seconds that a device takes to open or to close."""
        return self.devices.get(name, DEVICE_SECONDS)
