"""What a driver is, and the thread in which the exchanges of its devices happen."""
from __future__ import annotations

import queue
from typing import Callable, Optional, Protocol, Tuple

from fleet_devices.core.device import Exchange, Reading


class Silent(Exception):
    """A device was not read. The text says why, as a clause."""


class DevicePort(Protocol):
    """The way to one device. One thread calls it."""

    def exchange(self, output: Optional[bool]) -> Reading:
        """Sets the output, unless it is None; then reads the device. Raises Silent.

        It ends within some seconds, also if the device does not answer.
        """


OnEnd = Callable[[str, Optional[Reading], str], None]
"""Takes the name of a device, its reading (None: none), and why there is none."""


class ExchangeQueue:
    """Carries out the exchanges of all devices behind one connection, one after the other.

    on_end -- is called in the thread of `run`
    """

    def __init__(self, on_end: OnEnd) -> None:
        self._on_end = on_end
        self._waiting: queue.Queue[Optional[Tuple[str, DevicePort, Exchange]]] = queue.Queue()

    def put(self, name: str, driver: DevicePort, exchange: Exchange) -> None:
        """Queues an exchange; never waits."""
        self._waiting.put((name, driver, exchange))

    def end(self) -> None:
        """Ends `run` after the exchange that it carries out."""
        self._waiting.put(None)

    def run(self) -> None:
        """Carries out exchanges until `end`."""
        for name, driver, exchange in iter(self._waiting.get, None):
            try:
                reading = driver.exchange(exchange.output)
            except Silent as silent:
                self._on_end(name, None, str(silent))
            else:
                self._on_end(name, reading, '')
