"""The interface of drivers, and the queue of exchanges that one thread carries out."""
from __future__ import annotations

import queue
from typing import Callable, Optional, Protocol, TypeVar

from fleet_devices.core.device import Reading
from fleet_devices.core.hand_over import Signals, StartSignal

Kind = TypeVar('Kind')


class Silent(Exception):
    """A device was not read. The text is a clause with the reason."""


class DevicePort(Protocol):
    """The connection to one device. Only one thread calls it."""

    def exchange(self, output: Optional[bool]) -> Reading:
        """Sets the output, unless it is None; then reads the device. Raises Silent.

        It ends within some seconds, even if the device does not answer.
        """


class HandOverPort(Protocol):
    """The connection to one device that carries out hand-overs. Only one thread calls it."""

    def exchange(self, start: Optional[StartSignal]) -> Signals:
        """Writes the start output, unless it is None; then reads the device. Raises Silent.

        It writes at most once, and ends within some seconds, even if the device does not answer.
        """


class ExchangeQueue:
    """Carries out the exchanges of all devices behind one connection, one after the other."""

    def __init__(self) -> None:
        self._waiting: queue.Queue[Optional[Callable[[], None]]] = queue.Queue()

    def put(self, exchange: Callable[[], Kind],
            on_end: Callable[[Optional[Kind], str], None]) -> None:
        """Queues an exchange; never waits.

        on_end -- called in the thread of `run`, with the reading, or with None and the reason why
                  there is no reading
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
