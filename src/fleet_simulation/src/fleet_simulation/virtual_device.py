"""A simulated device, such as a door or a light."""
from __future__ import annotations

from typing import Optional, Tuple

from route_protocol.devices import DeviceMode, DeviceReport, DeviceRequest, DeviceUse

PERIOD = 1.0  # s; time between two reports if nothing changes


class VirtualDevice:
    """A device that opens while its newest request is OPEN, and closes otherwise.

    name    -- the name of the device and of its resource
    seconds -- s that the device takes to open or to close
    """

    def __init__(self, name: str, seconds: float = 2.0) -> None:
        self.name, self.seconds = name, seconds
        self.request: Optional[DeviceRequest] = None
        """The newest request that the device has received."""
        self.is_silent = False
        self._obeyed: Tuple[DeviceUse, ...] = ()
        self._open = 0.0  # 0: closed, 1: open
        self._told: Tuple[DeviceMode, Tuple[DeviceUse, ...]] = DeviceMode.UNKNOWN, ()
        self._since = 0.0
        self._count = 0

    def receive(self, request: DeviceRequest) -> None:
        """Obeys a request if it is newer than the request that the device obeys now."""
        if all(request.number > use.number for use in self._obeyed):
            self.request = request
            self._obeyed = (DeviceUse(request.requester, request.mode, request.number, 0.0),)

    @property
    def is_held(self) -> bool:
        """Whether its newest request is OPEN."""
        return self.request is not None and self.request.mode is DeviceMode.OPEN

    def advance(self, seconds: float) -> None:
        """Moves the device for the given virtual time, in s."""
        self._since += seconds
        step = seconds / self.seconds if self.is_held else -seconds / self.seconds
        self._open = min(max(self._open + step, 0.0), 1.0)

    def restart(self) -> None:
        """Restarts the device. It forgets the number of the request that it obeyed, but keeps
        moving as requested until the next request.
        """
        self._obeyed = ()

    @property
    def mode(self) -> DeviceMode:
        """The mode in which the device is."""
        if self._open >= 1.0:
            return DeviceMode.OPEN
        return DeviceMode.MOVING if self._open > 0.0 else DeviceMode.CLOSED

    def reports(self, now: float) -> Tuple[DeviceReport, ...]:
        """Returns the report that is due now: after each change, and once in each `PERIOD`."""
        news = self.mode, self._obeyed
        if self.is_silent or news == self._told and self._since < PERIOD:
            return ()
        self._told, self._since = news, 0.0
        self._count += 1
        return DeviceReport(self.name, self.mode, now, now, self._obeyed, count=self._count),
