"""All devices of a connection are read one after the other, in the order of the requests."""
from __future__ import annotations

from typing import List, Optional, Tuple

from fleet_devices.core.device import Reading
from fleet_devices.drivers.driver import ExchangeQueue, Silent


class Door:
    """A door: its readings follow its output, or it is silent."""

    def __init__(self, problem: str = '') -> None:
        self.problem = problem

    def exchange(self, output: Optional[bool]) -> Reading:
        if self.problem:
            raise Silent(self.problem)
        return Reading(bool(output), False)


def test_each_exchange_ends_once_in_order_and_a_silent_device_stops_no_other():
    ends: List[Tuple[str, Optional[Reading], str]] = []
    line = ExchangeQueue()

    def put(name: str, door: Door, output: Optional[bool]) -> None:
        line.put(lambda: door.exchange(output),
                 lambda reading, problem: ends.append((name, reading, problem)))
    put('gate', Door(), True)
    put('dead', Door('no answer'), True)
    put('gate', Door(), None)
    line.end()
    put('gate', Door(), None)
    line.run()
    assert ends == [('gate', Reading(True, False), ''), ('dead', None, 'no answer'),
                    ('gate', Reading(False, False), '')]
