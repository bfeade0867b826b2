"""Docked or not, and what that does to the battery."""
from __future__ import annotations

from typing import Callable, Optional

from omron_ld90_sim.behaviour.states import DockingState
from omron_ld90_sim.clock import Clock, Timer
from omron_ld90_sim.devices.battery import Battery, ChargeState
from omron_ld90_sim.motion.base import Base

CHARGE_CHECK = 1.0          # s between looks at the charger's phase


class Docking:
    """Docking state, charger and battery of one robot; tells `changed` of every new line."""

    def __init__(self, clock: Clock, base: Base, percent: float,
                 changed: Callable[[], None]) -> None:
        self.state, self.charge = DockingState.UNDOCKED, ChargeState.NOT
        self.battery = Battery(percent)
        self._clock, self._base, self._changed = clock, base, changed
        self._updated = clock.now
        self._timer: Optional[Timer] = None

    @property
    def line(self) -> str:
        """The DockingState line."""
        return (f'DockingState: {self.state.value} ForcedState: Unforced '
                f'ChargeState: {self.charge.value}')

    def begin_docked(self) -> None:
        """The robot stands in its dock since long, charged or charging."""
        self.battery.docked(charged_before=True)
        self.state, self.charge = DockingState.DOCKED, self.battery.charge_state
        self._watch()

    def enter(self, state: DockingState, charge: ChargeState) -> None:
        """Changes and announces the state."""
        self.state, self.charge = state, charge
        self._changed()
        self._watch()

    @property
    def percent(self) -> float:
        """The battery's state of charge, now."""
        self.update()
        return self.battery.percent

    def update(self) -> None:
        """Brings the battery up to now and announces a new charge phase."""
        elapsed, self._updated = self._clock.now - self._updated, self._clock.now
        if self.state is DockingState.DOCKED:
            self.battery.charge(elapsed)
            if self.battery.charge_state is not self.charge:
                self.enter(DockingState.DOCKED, self.battery.charge_state)
        else:
            self.battery.discharge(elapsed, not self._base.still)

    def _watch(self) -> None:
        """Follows the charger's phases until the battery is full."""
        charging = self.state is DockingState.DOCKED and self.charge is not ChargeState.FLOAT
        if charging and (self._timer is None or not self._timer.waiting):
            self._timer = self._clock.after(CHARGE_CHECK, self._look)

    def _look(self) -> None:
        self.update()
        self._watch()
