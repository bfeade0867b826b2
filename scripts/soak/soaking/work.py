"""The work of the soak: a PLC with a door and a press, and persons who answer steps.

The PLC notes what really happened: the keys with which the press was started and has finished.
"""
from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from typing import Counter as CounterType
from typing import Set

import plc
from fleet_core.work.devices import KEY_REGISTERS

logging.getLogger('pymodbus').setLevel(logging.CRITICAL)  # the soak kills the PLC on purpose

PRESS, DOOR = 'press', 'door'
HANDS_OVER = 3.0  # s


class SoakPlc(plc.Plc):
    """A PLC whose press hands loads over by itself. The PLC can be killed and can report wrong
    states, and its press can be broken. A PLC that loses its power also loses its registers.
    """

    def __init__(self) -> None:
        super().__init__()
        self.breaks = False
        """Whether each hand-over fails."""
        self.started: CounterType[int] = Counter()
        self.done: Set[int] = set()
        self._begun = 0.0
        self._fails = False
        self._guard = threading.Lock()

    @property
    def key(self) -> int:
        """The key that is in its registers."""
        return sum(self.registers.get(plc.KEY + k, 0) << 16 * (KEY_REGISTERS - 1 - k)
                   for k in range(KEY_REGISTERS))

    @property
    def is_working(self) -> bool:
        """Whether its press hands a load over now."""
        return self.coils.get(plc.START, False)

    @property
    def is_door_open(self) -> bool:
        """Whether the door is open: its output is set, and the PLC does not report wrong states."""
        return self.coils.get(plc.COIL, False) and not self.lies

    def _set(self, address: int, value: bool) -> None:
        with self._guard:
            if address == plc.START and value and not self.is_working:
                self.started[self.key] += 1
                self._begun, self._fails = time.monotonic(), self.breaks
            super()._set(address, value)

    def _input(self, address: int) -> bool:
        if address not in (plc.DONE, plc.FAILED):
            return super()._input(address)
        with self._guard:
            if not self.is_working or time.monotonic() < self._begun + HANDS_OVER:
                return False
            if not self._fails:
                self.done.add(self.key)
            return self._fails is (address == plc.FAILED)

    @property
    def repeated(self) -> Set[int]:
        """The keys with which the press was started more than once."""
        with self._guard:
            return {key for key, count in self.started.items() if count > 1}


def work_file(edge: int, port: int) -> str:
    """Returns the work file of the hall: a door on an edge, and a press, both driven by the PLC."""
    driver = f'driver: modbus, host: 127.0.0.1, port: {port}, unit: {plc.UNIT}'
    return (f'devices:\n- {{name: {DOOR}, kind: door, edges: [{edge}], timeout: 10, {driver}, '
            f'open_coil: {plc.COIL}, is_open: {plc.INPUT}}}\n'
            f'- {{name: {PRESS}, kind: machine, timeout: 10, {driver}, '
            f'start_coil: {plc.START}, key_register: {plc.KEY}, done: {plc.DONE}, '
            f'failed: {plc.FAILED}}}\n')
