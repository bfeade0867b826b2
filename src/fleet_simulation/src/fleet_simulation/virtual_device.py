"""A simulated device: a door or a light that opens while its newest request holds it."""
from __future__ import annotations

from typing import Optional, Tuple

from route_protocol.devices import DeviceMode, DeviceReport, DeviceRequest, DeviceUse

PERIOD = 1.0  # s between two reports if nothing changes


class VirtualDevice:
    """A device that opens while its request holds it, and closes otherwise.

    name    -- its name, which is that of its resource
    seconds -- s that it takes to open or to close
    """

    def __init__(self, name: str, seconds: float = 2.0) -> None:
        self.name, self.seconds = name, seconds
        self.request: Optional[DeviceRequest] = None
        """The newest request that it has taken."""
        self.is_silent = False
        self._obeyed: Tuple[DeviceUse, ...] = ()
        self._open = 0.0  # share of the way
        self._told: Tuple[DeviceMode, Tuple[DeviceUse, ...]] = DeviceMode.UNKNOWN, ()
        self._since = 0.0
        self._count = 0

    def receive(self, request: DeviceRequest) -> None:
        """Handles a request. One that is not newer changes nothing."""
        if all(request.number > use.number for use in self._obeyed):
            self.request = request
            self._obeyed = (DeviceUse(request.requester, request.mode, request.number, 0.0),)

    @property
    def is_held(self) -> bool:
        """Whether it is to be open."""
        return self.request is not None and self.request.mode is DeviceMode.OPEN

    def advance(self, seconds: float) -> None:
        """Moves for the given virtual time, in s."""
        self._since += seconds
        step = seconds / self.seconds if self.is_held else -seconds / self.seconds
        self._open = min(max(self._open + step, 0.0), 1.0)

    def restart(self) -> None:
        """Restarts: it does not know then which request it obeys,
        and stays as it is until the next.
        """
        self._obeyed = ()

    @property
    def mode(self) -> DeviceMode:
        """What it does."""
        if self._open >= 1.0:
            return DeviceMode.OPEN
        return DeviceMode.MOVING if self._open > 0.0 else DeviceMode.CLOSED

    def reports(self, now: float) -> Tuple[DeviceReport, ...]:
        """Returns what it reports now: at each change, and once in each period."""
        news = self.mode, self._obeyed
        if self.is_silent or news == self._told and self._since < PERIOD:
            return ()
        self._told, self._since = news, 0.0
        self._count += 1
        return DeviceReport(self.name, self.mode, now, now, self._obeyed, count=self._count),
