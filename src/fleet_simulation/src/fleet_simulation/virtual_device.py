"""A simulated device: a door or a light that opens for the robots of the newest request."""
from __future__ import annotations

from typing import Tuple

from fleet_core.interlocking.resources import DeviceDemand, DeviceReading
from route_protocol.devices import DeviceMode

PERIOD = 1.0  # s between two reports if nothing changes


class VirtualDevice:
    """A device that opens while its request names robots, and closes while it names none.

    resource -- name of its resource
    seconds  -- s that it takes to open or to close
    """

    def __init__(self, resource: str, seconds: float = 2.0) -> None:
        self.resource, self.seconds = resource, seconds
        self.robots: Tuple[str, ...] = ()
        """The robots for which it is to be open."""
        self.is_silent = False
        self._request = 0
        self._open = 0.0  # share of the way
        self._told: Tuple[DeviceMode, int] = DeviceMode.UNKNOWN, 0
        self._since = 0.0

    def receive(self, request: DeviceDemand) -> None:
        """Handles a request. One that is not newer changes nothing."""
        if request.number > self._request:
            self._request, self.robots = request.number, request.robots

    def advance(self, seconds: float) -> None:
        """Moves for the given virtual time, in s."""
        self._since += seconds
        step = seconds / self.seconds if self.robots else -seconds / self.seconds
        self._open = min(max(self._open + step, 0.0), 1.0)

    def restart(self) -> None:
        """It restarts: it forgets its request, and stays as it is until the next one."""
        self._request = 0

    @property
    def mode(self) -> DeviceMode:
        """What it does."""
        if self._open >= 1.0:
            return DeviceMode.OPEN
        return DeviceMode.MOVING if self._open > 0.0 else DeviceMode.CLOSED

    def reports(self) -> Tuple[DeviceReading, ...]:
        """What it reports now: at each change, and once in each period."""
        news = self.mode, self._request
        if self.is_silent or news == self._told and self._since < PERIOD:
            return ()
        self._told, self._since = news, 0.0
        return DeviceReading(self.resource, self.mode, self._request),
