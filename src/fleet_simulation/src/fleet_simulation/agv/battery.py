"""The battery of a simulated AGV."""
from __future__ import annotations

from dataclasses import dataclass

STANDING = 3.0 / 3600.0    # per cent of a full battery per second, like the next two constants
DRIVING = 12.0 / 3600.0
CHARGING = 60.0 / 3600.0


@dataclass
class SimulatedBattery:
    """A battery; `charge` is in per cent."""

    charge: float = 100.0
    charging: bool = False

    def advance(self, seconds: float, driving: bool, at_charger: bool) -> None:
        """Simulates the next `seconds`."""
        self.charging = at_charger and not driving
        rate = CHARGING if self.charging else -(DRIVING if driving else STANDING)
        self.charge = min(max(self.charge + rate * seconds, 0.0), 100.0)
