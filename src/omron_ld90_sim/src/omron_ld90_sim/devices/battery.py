"""The battery: its charge falls while the robot stands or drives, and rises at the dock."""
from __future__ import annotations

from enum import Enum

DRAIN_STANDING = 4.0 / 3600     # percent per second; assumed: the battery lasts for about a day
DRAIN_DRIVING = 8.0 / 3600      # the battery lasts for about twelve hours
CHARGE = 25.0 / 3600            # four hours from empty to full
BULK_TIME = 5.0                 # s, minimum time of Bulk before Overcharge
OVERCHARGE_TIME = 15.0          # s after docking before Float
OVERCHARGE_FROM = 75.0          # percent
FULL = 99.9


class ChargeState(Enum):
    """The ChargeState field of a DockingState line."""

    NOT = 'Not'
    BULK = 'Bulk'
    OVERCHARGE = 'Overcharge'
    FLOAT = 'Float'


class SimBattery:
    """The state of charge, which changes with time."""

    def __init__(self, percent: float) -> None:
        self.percent = percent
        self._since_docked = 0.0

    def docked(self, charged_before: bool = False) -> None:
        """Notes that the charger was connected just now; if `charged_before`, long ago."""
        self._since_docked = OVERCHARGE_TIME if charged_before else 0.0

    def discharge(self, seconds: float, driving: bool) -> None:
        """Discharges for a time off the charger."""
        self.percent = max(self.percent - seconds * (DRAIN_DRIVING if driving else DRAIN_STANDING),
                           0.0)

    def charge(self, seconds: float) -> None:
        """Charges for a time on the charger."""
        self._since_docked += seconds
        self.percent = min(self.percent + seconds * CHARGE, 100.0)

    @property
    def charge_state(self) -> ChargeState:
        """The charger's phase while docked."""
        if self._since_docked < BULK_TIME or self.percent < OVERCHARGE_FROM:
            return ChargeState.BULK
        if self._since_docked < OVERCHARGE_TIME or self.percent < FULL:
            return ChargeState.OVERCHARGE
        return ChargeState.FLOAT
