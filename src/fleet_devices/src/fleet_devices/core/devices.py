"""All devices of a site: their stored memory, the exchanges and the reports that are due."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

from fleet_devices.core.device import (
    LOST,
    DeviceLimits,
    DeviceMachine,
    DeviceMemory,
    Exchange,
    Reading,
)
from route_protocol.devices import DeviceReport, DeviceRequest

REPORT_PERIOD = 0.5  # s between two reports of a device that does not change


@dataclass(frozen=True)
class StoredDevices:
    """The stored data of all devices. `run`: the number of the run that has stored it."""

    run: int = 0
    devices: Mapping[str, DeviceMemory] = field(default_factory=dict)


class Periods(NamedTuple):
    """Times (s).

    exchange -- between the beginnings of two exchanges with one device
    report   -- between two reports of one device, if the device does not change
    """

    exchange: float
    report: float = REPORT_PERIOD


class _Told(NamedTuple):
    """The last report of a device, its time, and the state of the device that it shows."""

    device: DeviceMachine
    report: DeviceReport
    at: float


class Devices:
    """The devices by their names. `now` is in s of a clock that never steps back.

    memory -- the stored data; a device that is missing there starts with the memory LOST
    store  -- stores a new memory; raises OSError if it cannot
    least_run -- the smallest number that this run may have
    """

    def __init__(self, limits: Mapping[str, DeviceLimits], memory: StoredDevices,
                 store: Callable[[StoredDevices], None], least_run: int, periods: Periods,
                 now: float) -> None:
        self.run = max(memory.run + 1, least_run)
        self.problem = ''  # why the memory cannot be stored; empty: it is stored
        self._store, self._periods = store, periods
        self._kept = dict(memory.devices)  # also has devices that the site lacks now
        self._devices: Dict[str, DeviceMachine] = {
            name: DeviceMachine.start(one, memory.devices.get(name, LOST), now)
            for name, one in limits.items()}
        self._due: Dict[str, float] = dict.fromkeys(limits, now)
        self._told: Dict[str, _Told] = {}
        self._count = 0
        self._keep()

    def __getitem__(self, name: str) -> DeviceMachine:
        return self._devices[name]

    # --- events -----------------------------------------------------------------------------------

    def receive(self, request: DeviceRequest, now: float, stamp: float) -> str:
        """Takes a request. Returns a clause that says why it is refused; empty: it is taken.

        The request is stored before it has any effect.
        """
        device = self._devices.get(request.device)
        if device is None:
            return f'there is no device {request.device}'
        refusal = device.refusal(request)
        if refusal:
            return refusal
        after = device.ask(request, now, stamp)
        if after is not device:
            self._devices[request.device] = after
            if after.memory != device.memory and not self._keep():
                self._devices[request.device] = device
                return f'it cannot be stored: {self.problem}'
        return ''

    def begin_due(self, now: float) -> List[Tuple[str, Exchange]]:
        """Begins the exchanges that are due, and returns them."""
        exchanges = []
        for name, device in self._devices.items():
            if not device.is_awaited and (now >= self._due[name] or device.is_urgent):
                self._devices[name], exchange = device.begin(now)
                self._due[name] = now + self._periods.exchange
                exchanges.append((name, exchange))
        return exchanges

    def ended(self, name: str, reading: Optional[Reading], problem: str, now: float) -> None:
        """Notes that an exchange has ended. `reading` None: not read, because of `problem`."""
        self._change(name, self._devices[name].end(reading, problem, now))

    def tick(self, now: float) -> None:
        """Notes that time has passed."""
        for name, device in list(self._devices.items()):
            self._change(name, device.tick(now))

    def reports(self, now: float) -> List[DeviceReport]:
        """Returns the reports that are due: of changed devices, and of others periodically.

        `since` and `read_at` are times of the same clock as `now`; times in `obeyed` are stamps.
        """
        due = []
        for name, device in self._devices.items():
            told = self._told.get(name)
            is_due = told is None or now - told.at >= self._periods.report
            if told is not None and told.device is device and not is_due:
                continue
            news = device.report(name)
            if told is None or is_due or replace(told.report, read_at=news.read_at) != news:
                told = _Told(device, news, now)
                self._count += 1
                due.append(replace(news, run=self.run, count=self._count))
            self._told[name] = told._replace(device=device)
        return due

    # --- memory -----------------------------------------------------------------------------------

    def _change(self, name: str, after: DeviceMachine) -> None:
        """Adopts a change that does not come from a request.

        Such a change only removes data from the memory. So the older memory does no harm if the new
        memory cannot be stored.
        """
        before, self._devices[name] = self._devices[name], after
        if after.memory != before.memory:
            self._keep()

    def _keep(self) -> bool:
        memory = StoredDevices(self.run, {**self._kept, **{
            name: device.memory for name, device in self._devices.items()}})
        try:
            self._store(memory)
        except OSError as error:
            self.problem = error.strerror or str(error)
            return False
        self.problem = ''
        return True
