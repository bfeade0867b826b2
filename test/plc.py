"""A PLC with a door and a press, on a server of pymodbus. It can be killed, started again, and
report wrong states.
"""
from __future__ import annotations

import asyncio
import contextlib
import inspect
import socket
import threading
from types import TracebackType
from typing import Any, Callable, Dict, List, Optional, Type

import pymodbus.datastore as store

try:
    from pymodbus.server import ModbusTcpServer
except ImportError:  # 3.0
    from pymodbus.server.async_io import ModbusTcpServer

from fleet_core.work.devices import HandOverAddress, ModbusAddress
from ports import free_port

COIL, INPUT, UNIT = 3, 11, 7
START, KEY, DONE, FAILED = 5, 20, 12, 13  # addresses of the press
_OFFSET = 1  # pymodbus's contexts number coils and inputs from 1


class _Bits(store.ModbusSequentialDataBlock):
    """The bits of the server: one function reads a bit, and another function writes it."""

    def __init__(self, read: Callable[[int], Any], write: Callable[[int, Any], None]) -> None:
        super().__init__(0, [0])
        self._read, self._write = read, write

    def validate(self, address: int, count: int = 1) -> bool:
        return 0 < address <= 100

    def getValues(self, address: int, count: int = 1) -> List[Any]:  # noqa: N802 pymodbus's name
        return [self._read(address - _OFFSET + k) for k in range(count)]

    def setValues(self, address: int, values: Any) -> None:  # noqa: N802 pymodbus's name
        for k, value in enumerate(values if isinstance(values, list) else [values]):
            self._write(address - _OFFSET + k, bool(value))


class _Registers(_Bits):
    """The registers of the server, read and written in the same way."""

    def setValues(self, address: int, values: Any) -> None:  # noqa: N802 pymodbus's name
        for k, value in enumerate(values):
            self._write(address - _OFFSET + k, value)


class Plc:
    """A PLC. It reports its door as open while the door's coil is set; if it `lies`, it reports the
    opposite.

    Its press works while the coil `start` is on. The test decides when the press reports that it is
    done or has failed.
    """

    def __init__(self) -> None:
        self.port = free_port()
        self.coils: Dict[int, bool] = {}
        self.registers: Dict[int, int] = {}
        self.starts = 0
        self.is_done = self.has_failed = False
        self.lies = False
        self.ignores = False
        self._loop: Optional[asyncio.AbstractEventLoop] = None
        self._task: Any = None
        self._thread: Optional[threading.Thread] = None

    @property
    def press(self) -> HandOverAddress:
        """The address of the press."""
        return HandOverAddress('127.0.0.1', START, KEY, DONE, FAILED, self.port, UNIT)

    @property
    def address(self) -> ModbusAddress:
        """The address of the door."""
        return ModbusAddress('127.0.0.1', COIL, INPUT, self.port, UNIT)

    def __enter__(self) -> Plc:
        self.start()
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.kill()

    def start(self) -> None:
        """Starts the PLC with all coils off, as after a power cut."""
        self.coils, self.registers = {}, {}
        listening = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve(listening)),
                                        daemon=True)
        self._thread.start()
        assert listening.wait(10)

    def kill(self) -> None:
        """Ends the PLC and all its connections."""
        if self._thread is not None and self._loop is not None:
            self._loop.call_soon_threadsafe(self._task.cancel)
            self._thread.join(10)
            assert not self._thread.is_alive()
            self._thread = None

    async def _serve(self, listening: threading.Event) -> None:
        self._loop = asyncio.get_running_loop()
        device = getattr(store, 'ModbusDeviceContext', None) or store.ModbusSlaveContext
        never = _Bits(lambda _: False, lambda _, __: None)
        context = store.ModbusServerContext({UNIT: device(
            di=_Bits(self._input, lambda _, __: None),
            co=_Bits(lambda address: self.coils.get(address, False), self._set),
            ir=never, hr=_Registers(lambda address: self.registers.get(address, 0),
                                    self.registers.__setitem__))}, single=False)
        names = inspect.signature(ModbusTcpServer.__init__).parameters
        reuse = {'allow_reuse_address': True} if 'allow_reuse_address' in names else {}
        server = ModbusTcpServer(context, address=('127.0.0.1', self.port), **reuse)
        self._task = asyncio.ensure_future(server.serve_forever())
        while not await self._loop.run_in_executor(None, _listens, self.port):
            await asyncio.sleep(0.01)
        listening.set()
        with contextlib.suppress(asyncio.CancelledError):  # some versions of pymodbus swallow it
            await self._task
        await server.shutdown()

    def _input(self, address: int) -> bool:
        if address in (DONE, FAILED):
            return self.coils.get(START, False) and (
                self.is_done if address == DONE else self.has_failed)
        return address == INPUT and self.coils.get(COIL, False) is not self.lies

    def _set(self, address: int, value: bool) -> None:
        if not self.ignores:
            self.starts += address == START and value and not self.coils.get(START, False)
            self.coils[address] = value


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(('127.0.0.1', port)) == 0
