"""Devices behind a Modbus TCP server, such as a PLC.

A door or a light has one coil and one discrete input. A device that carries out hand-overs has a
coil to start it, two discrete inputs, and four holding registers for the key of the step.
The client is pymodbus, from 2.1 (Ubuntu 20.04) to 3.x. After an error a connection is closed,
because a late answer could be mistaken for the answer to the next request.
"""
from __future__ import annotations

import inspect
import logging
import time
from importlib import import_module
from typing import Any, Callable, Dict, List, NoReturn, Optional

from fleet_core.work.devices import KEY_REGISTERS, HandOverAddress, ModbusAddress
from fleet_devices.core.device import Reading
from fleet_devices.core.hand_over import Signals, StartSignal
from fleet_devices.drivers.driver import Silent

TIMEOUT = 1.0  # s for a connection, and for an answer
PAUSE = 1.0    # s after a failed connection before the next one

logging.getLogger('pymodbus').setLevel(logging.CRITICAL)  # the driver raises Silent instead

Clock = Callable[[], float]
Request = Callable[[Any], Any]
"""Sends a request with a client, and returns the answer."""


def unit_argument(method: Callable[..., Any], unit: int) -> Dict[str, int]:
    """Returns the argument of a method of pymodbus that names the unit.

    The name of the argument depends on the version: `unit` (2.x, not in the signature), `slave`
    (3.0 to 3.9), `device_id` (from 3.10 on). Some versions do not refuse a wrong name, but ignore
    it and address unit 0. So this function looks at the signature, not at the version.
    """
    names = inspect.signature(method).parameters
    for name in ('device_id', 'slave'):
        if name in names:
            return {name: unit}
    return {'unit': unit}


class ModbusConnection:
    """The connection to one server. Only one thread calls it."""

    def __init__(self, host: str, port: int, clock: Clock = time.monotonic) -> None:
        self._host, self._port, self._clock = host, port, clock
        self._client: Any = None
        self._next = clock()  # when the next connection may be tried
        self._problem = ''

    def call(self, request: Request) -> Any:
        """Sends a request and returns its answer. Raises Silent, also if the answer is an error."""
        client = self._connected()
        try:
            answer = request(client)
        except Exception as error:  # pymodbus, asyncio, socket and struct raise many kinds
            self._fail(f'{type(error).__name__}: {error}')
        if answer is None or isinstance(answer, Exception):
            self._fail(str(answer) if answer is not None else 'no answer')
        if answer.isError():
            if not hasattr(answer, 'exception_code'):  # the connection is in an unknown state
                self._fail(str(answer))
            raise Silent(f'{self._host}:{self._port} refuses the request: {answer}'[:200])
        return answer

    def close(self) -> None:
        """Closes the connection."""
        client, self._client = self._client, None
        if client is not None:
            client.close()

    def _connected(self) -> Any:
        if self._client is not None:
            return self._client
        if self._clock() < self._next:
            raise Silent(self._problem)
        self._next = self._clock() + PAUSE
        client = new_client(self._host, self._port)
        self._client = client
        try:
            is_connected = client.connect()
        except Exception as error:
            self._fail(f'{type(error).__name__}: {error}')
        if not is_connected:
            self._fail('no connection')
        return client

    def _fail(self, why: str) -> NoReturn:
        self.close()
        self._problem = f'{self._host}:{self._port} does not answer: {why}'[:200]
        raise Silent(self._problem)


class ModbusUnit:
    """The coils, inputs and registers of one unit behind a connection. All methods raise Silent."""

    def __init__(self, connection: ModbusConnection, unit: int) -> None:
        self._connection, self._unit = connection, unit

    def set_coil(self, address: int, is_on: bool) -> None:
        """Sets a coil."""
        self._call('write_coil', address, is_on)

    def set_registers(self, address: int, values: List[int]) -> None:
        """Sets holding registers from `address` on."""
        self._call('write_registers', address, values)

    def coil(self, address: int) -> bool:
        """Returns whether a coil is on."""
        return self._bit('read_coils', address)

    def input(self, address: int) -> bool:
        """Returns whether a discrete input is on."""
        return self._bit('read_discrete_inputs', address)

    def registers(self, address: int, count: int) -> List[int]:
        """Reads holding registers from `address` on."""
        values = getattr(self._call('read_holding_registers', address, count=count), 'registers',
                         None)
        if not isinstance(values, list) or len(values) != count or not all(
                isinstance(one, int) and 0 <= one <= 0xFFFF for one in values):
            raise Silent(f'the answer about {address} does not have {count} registers')
        return values

    def _bit(self, method: str, address: int) -> bool:
        bits = getattr(self._call(method, address, count=1), 'bits', None)
        if not bits or not isinstance(bits[0], bool):
            raise Silent(f'the answer about {address} has no bit')
        return bits[0]

    def _call(self, method: str, *arguments: Any, **named: Any) -> Any:
        def send(client: Any) -> Any:
            function = getattr(client, method)
            return function(*arguments, **named, **unit_argument(function, self._unit))
        return self._connection.call(send)


class ModbusDevice:
    """One door, light or similar device behind a connection."""

    def __init__(self, connection: ModbusConnection, address: ModbusAddress) -> None:
        self._unit, self._address = ModbusUnit(connection, address.unit), address

    def exchange(self, output: Optional[bool]) -> Reading:
        """Sets the coil, and reads the coil and the input. Raises Silent."""
        if output is not None:
            self._unit.set_coil(self._address.open_coil, output)
        return Reading(self._unit.coil(self._address.open_coil),
                       self._unit.input(self._address.is_open))


class ModbusHandOver:
    """One device that carries out hand-overs, behind a connection."""

    def __init__(self, connection: ModbusConnection, address: HandOverAddress) -> None:
        self._unit, self._address = ModbusUnit(connection, address.unit), address

    def exchange(self, start: Optional[StartSignal]) -> Signals:
        """Writes the key and then the start coil, and reads all signals. Raises Silent."""
        unit, address = self._unit, self._address
        if start is not None:
            if start.is_on:
                unit.set_registers(address.key_register, words_of(start.key))
            unit.set_coil(address.start_coil, start.is_on)
        return Signals(unit.coil(address.start_coil),
                       key_of(unit.registers(address.key_register, KEY_REGISTERS)),
                       unit.input(address.done), unit.input(address.failed))


def words_of(key: int) -> List[int]:
    """Returns the register values of a key."""
    return [key >> 16 * k & 0xFFFF for k in reversed(range(KEY_REGISTERS))]


def key_of(words: List[int]) -> int:
    """Returns the key with these register values."""
    return sum(word << 16 * k for k, word in enumerate(reversed(words)))


def client_class() -> Any:
    """Returns the class of clients of any version of pymodbus. Raises ImportError."""
    from pymodbus import client
    if hasattr(client, 'ModbusTcpClient'):
        return client.ModbusTcpClient
    return import_module('pymodbus.client.sync').ModbusTcpClient  # before 3.0


def new_client(host: str, port: int) -> Any:
    """Returns a client that does not repeat requests by itself."""
    return client_class()(host, port=port, timeout=TIMEOUT, retries=0)
