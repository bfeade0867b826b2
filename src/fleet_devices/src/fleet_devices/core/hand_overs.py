"""All devices of a site that carry out steps: their memory, and the exchanges and reports that are
due.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

from fleet_devices.core.device import DeviceLimits
from fleet_devices.core.hand_over import HandOverMachine, HandOverMemory, Signals, StartSignal
from route_protocol.steps import StepCommand, StepReport

REPORT_PERIOD = 1.0  # s between two reports of a device whose steps do not change


@dataclass(frozen=True)
class StoredHandOvers:
    """The stored data of all devices, by name."""

    devices: Mapping[str, HandOverMemory] = field(default_factory=dict)


class _Told(NamedTuple):
    """The last report of a device: its steps, and when it was made."""

    steps: object
    at: float


class HandOvers:
    """The devices by their names. `now` is in s of a clock that never steps back.

    memory -- the stored data; a device that is not in it begins the run `new_run`
    store  -- stores a new memory; raises OSError if it cannot
    period -- s between the beginnings of two exchanges with a device

    Until the memory of this start is stored, no command is taken, and no report is made.
    """

    def __init__(self, limits: Mapping[str, DeviceLimits], memory: StoredHandOvers,
                 store: Callable[[StoredHandOvers], None], new_run: int, period: float,
                 now: float) -> None:
        self.problem = ''  # why the memory cannot be stored; empty: it is stored
        self._store, self._period = store, period
        self._kept = dict(memory.devices)  # also has devices that the site lacks now
        self._devices: Dict[str, HandOverMachine] = {
            name: HandOverMachine.start(
                one, memory.devices.get(name) or HandOverMemory(new_run), now)
            for name, one in limits.items()}
        self._due: Dict[str, float] = dict.fromkeys(limits, now)
        self._told: Dict[str, _Told] = {}
        self._is_begun = not limits or self._keep(self._devices)

    def __getitem__(self, name: str) -> HandOverMachine:
        return self._devices[name]

    @property
    def names(self) -> Tuple[str, ...]:
        """The names of all devices."""
        return tuple(self._devices)

    # --- events -----------------------------------------------------------------------------------

    def receive(self, name: str, command: StepCommand, now: float) -> None:
        """Takes a command. A command that cannot be stored is ignored, because it is repeated."""
        if self._is_begun:
            self._change(name, self._devices[name].obey(command, now))

    def begin_due(self, now: float) -> List[Tuple[str, Optional[StartSignal]]]:
        """Begins the exchanges that are due. Returns their devices, each with the signal to write.

        The memory of these devices is already stored.
        """
        exchanges: List[Tuple[str, Optional[StartSignal]]] = []
        if not self._is_begun:
            self._is_begun = self._keep(self._devices)
        for name, device in self._devices.items() if self._is_begun else ():
            if not device.is_awaited and (now >= self._due[name] or device.is_urgent):
                self._due[name] = now + self._period
                after, write = device.begin(now)
                if self._change(name, after):
                    exchanges.append((name, write))
        return exchanges

    def ended(self, name: str, signals: Optional[Signals], problem: str, now: float) -> None:
        """Notes that an exchange has ended. `signals` None: not read, because of `problem`."""
        device = self._devices[name]
        if not self._change(name, device.end(signals, problem, now)):
            self._devices[name] = replace(device, is_awaited=False)  # the device is read again

    def tick(self, now: float) -> None:
        """Notes that time has passed."""
        for name, device in list(self._devices.items()):
            self._change(name, device.tick(now))

    def reports(self, now: float) -> List[Tuple[str, StepReport]]:
        """Returns the reports that are due: of devices whose steps have changed, and of others
        periodically.
        """
        due = []
        for name, device in self._devices.items() if self._is_begun else ():
            told = self._told.get(name)
            steps = device.actor.last, device.actor.steps
            if told is None or told.steps != steps or now - told.at >= REPORT_PERIOD:
                self._told[name] = _Told(steps, now)
                actor, report = device.actor.report()
                self._devices[name] = replace(device, actor=actor)
                due.append((name, report))
        return due

    # --- memory -----------------------------------------------------------------------------------

    def _change(self, name: str, after: HandOverMachine) -> bool:
        """Adopts a change after it is stored. Returns whether it could be stored."""
        if after.memory != self._devices[name].memory and not self._keep(
                {**self._devices, name: after}):
            return False
        self._devices[name] = after
        return True

    def _keep(self, devices: Mapping[str, HandOverMachine]) -> bool:
        try:
            self._store(StoredHandOvers({**self._kept, **{
                name: device.memory for name, device in devices.items()}}))
        except OSError as error:
            self.problem = error.strerror or str(error)
            return False
        self.problem = ''
        return True
