"""What a driver is, and the thread in which the exchanges of its devices happen."""
from __future__ import annotations

import queue
from typing import Callable, Optional, Protocol, TypeVar

from fleet_devices.core.device import Reading
from fleet_devices.core.hand_over import Signals, StartSignal

Kind = TypeVar('Kind')


class Silent(Exception):
    """A device was not read. The text says why, as a clause."""


class DevicePort(Protocol):
    """The way to one device. One thread calls it."""

    def exchange(self, output: Optional[bool]) -> Reading:
        """Sets the output, unless it is None; then reads the device. Raises Silent.

        It ends within some seconds, also if the device does not answer.
        """


class HandOverPort(Protocol):
    """The way to one device that hands over. One thread calls it."""

    def exchange(self, start: Optional[StartSignal]) -> Signals:
        """Writes the start output, unless it is None; then reads the device. Raises Silent.

        It writes once at most, and ends within some seconds, also if the device does not answer.
        """


class ExchangeQueue:
    """Carries out the exchanges of all devices behind one connection, one after the other."""

    def __init__(self) -> None:
        self._waiting: queue.Queue[Optional[Callable[[], None]]] = queue.Queue()

    def put(self, exchange: Callable[[], Kind],
            on_end: Callable[[Optional[Kind], str], None]) -> None:
        """Queues an exchange; never waits.

        on_end -- is called with its reading (None: none) and why there is none, in the thread of
                  `run`
        """
        def carry_out() -> None:
            try:
                reading = exchange()
            except Silent as silent:
                on_end(None, str(silent))
            else:
                on_end(reading, '')
        self._waiting.put(carry_out)

    def end(self) -> None:
        """Ends `run` after the exchange that it carries out."""
        self._waiting.put(None)

    def run(self) -> None:
        """Carries out exchanges until `end`."""
        for carry_out in iter(self._waiting.get, None):
            carry_out()
