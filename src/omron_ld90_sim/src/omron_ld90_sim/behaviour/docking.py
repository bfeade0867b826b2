"""The docking state and its effect on the battery.

    state       event                              next state
    UNDOCKED    `dock` begins                      DOCKING
    DOCKING     the robot is in the station        DOCKED
                it misses the station              UNDOCKING
                the activity ends                  UNDOCKED
    DOCKED      a drive or `undock` begins         UNDOCKING
                a person pushes the robot          UNDOCKED
    UNDOCKING   the robot is out of the station    UNDOCKED
                the activity ends                  UNDOCKED

Invariants: the battery is charged only while DOCKED. Each change is announced once.
"""
from __future__ import annotations

from typing import Callable, Optional

from omron_ld90_sim.behaviour.states import DockingPhase
from omron_ld90_sim.clock import SimClock, Timer
from omron_ld90_sim.devices.battery import ChargeState, SimBattery
from omron_ld90_sim.motion.base import Base

CHARGE_CHECK = 1.0          # s between two checks of the charger's phase


class Docking:
    """Docking state, charger and battery of one robot.

    After each change, calls `changed`, which announces `line`.
    """

    def __init__(self, clock: SimClock, base: Base, percent: float,
                 changed: Callable[[], None]) -> None:
        self.state, self.charge = DockingPhase.UNDOCKED, ChargeState.NOT
        self.battery = SimBattery(percent)
        self._clock, self._base, self._changed = clock, base, changed
        self._updated = clock.now
        self._timer: Optional[Timer] = None

    @property
    def line(self) -> str:
        """The DockingState line."""
        return (f'DockingState: {self.state.value} ForcedState: Unforced '
                f'ChargeState: {self.charge.value}')

    def begin_docked(self) -> None:
        """Sets the state of a robot that has been in its dock for long, charging or charged."""
        self.battery.docked(charged_before=True)
        self.state, self.charge = DockingPhase.DOCKED, self.battery.charge_state
        self._watch()

    def enter(self, state: DockingPhase, charge: ChargeState) -> None:
        """Changes and announces the state."""
        self.state, self.charge = state, charge
        self._changed()
        self._watch()

    @property
    def percent(self) -> float:
        """The battery's present state of charge."""
        self.update()
        return self.battery.percent

    def update(self) -> None:
        """Updates the battery to the present time, and announces a new charge phase."""
        elapsed, self._updated = self._clock.now - self._updated, self._clock.now
        if self.state is DockingPhase.DOCKED:
            self.battery.charge(elapsed)
            if self.battery.charge_state is not self.charge:
                self.enter(DockingPhase.DOCKED, self.battery.charge_state)
        else:
            self.battery.discharge(elapsed, not self._base.still)

    def _watch(self) -> None:
        """Checks the charger's phase repeatedly until the battery is full."""
        charging = self.state is DockingPhase.DOCKED and self.charge is not ChargeState.FLOAT
        if charging and (self._timer is None or not self._timer.waiting):
            self._timer = self._clock.after(CHARGE_CHECK, self._check_charger)

    def _check_charger(self) -> None:
        self.update()
        self._watch()
