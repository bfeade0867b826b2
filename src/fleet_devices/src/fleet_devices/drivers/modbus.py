"""Doors and lights behind a Modbus TCP server, such as a PLC: one coil, one discrete input.

The client is pymodbus, from 2.1 (Ubuntu 20.04) to 3.x. A connection that has failed is closed: an
answer that comes late would be taken for that of the next request.
"""
from __future__ import annotations

import inspect
import logging
import time
from importlib import import_module
from typing import Any, Callable, Dict, NoReturn, Optional

from fleet_core.work.devices import ModbusAddress
from fleet_devices.core.device import Reading
from fleet_devices.drivers.driver import Silent

TIMEOUT = 1.0  # s for a connection, and for an answer
PAUSE = 1.0    # s after a failed connection before the next one

logging.getLogger('pymodbus').setLevel(logging.CRITICAL)  # Silent says what has failed

Clock = Callable[[], float]
Request = Callable[[Any], Any]
"""Sends a request with a client, and returns the answer."""


def unit_argument(method: Callable[..., Any], unit: int) -> Dict[str, int]:
    """Returns the argument of a method of pymodbus that names the unit.

    Its name has changed within minor versions: `unit` (2.x, without a name in the signature),
    `slave` (3.0 to 3.9), `device_id` (from 3.10 on). A wrong name is not refused by all versions:
    some ignore it, and ask unit 0. So the signature decides, not the version.
    """
    names = inspect.signature(method).parameters
    for name in ('device_id', 'slave'):
        if name in names:
            return {name: unit}
    return {'unit': unit}


class ModbusConnection:
    """The connection to one server. One thread calls it."""

    def __init__(self, host: str, port: int, clock: Clock = time.monotonic) -> None:
        self._host, self._port, self._clock = host, port, clock
        self._client: Any = None
        self._next = clock()  # when the next connection may be tried
        self._problem = ''

    def call(self, request: Request) -> Any:
        """Sends a request and returns its answer, which is no error. Raises Silent."""
        client = self._connected()
        try:
            answer = request(client)
        except Exception as error:  # pymodbus and its asyncio, socket and struct raise many kinds
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


class ModbusDevice:
    """One device behind a connection."""

    def __init__(self, connection: ModbusConnection, address: ModbusAddress) -> None:
        self._connection, self._address = connection, address

    def exchange(self, output: Optional[bool]) -> Reading:
        """Sets the coil, and reads the coil and the input. Raises Silent."""
        if output is not None:
            self._connection.call(lambda client: client.write_coil(
                self._address.open_coil, output, **self._unit(client.write_coil)))
        return Reading(self._bit('read_coils', self._address.open_coil),
                       self._bit('read_discrete_inputs', self._address.is_open))

    def _unit(self, method: Callable[..., Any]) -> Dict[str, int]:
        return unit_argument(method, self._address.unit)

    def _bit(self, method: str, address: int) -> bool:
        def read(client: Any) -> Any:
            function = getattr(client, method)
            return function(address, count=1, **self._unit(function))
        bits = getattr(self._connection.call(read), 'bits', None)
        if not bits or not isinstance(bits[0], bool):
            raise Silent(f'the answer about {address} has no bit')
        return bits[0]


def client_class() -> Any:
    """Returns the class of clients of any version of pymodbus. Raises ImportError."""
    from pymodbus import client
    if hasattr(client, 'ModbusTcpClient'):
        return client.ModbusTcpClient
    return import_module('pymodbus.client.sync').ModbusTcpClient  # before 3.0


def new_client(host: str, port: int) -> Any:
    """Returns a client that sends nothing twice by itself."""
    return client_class()(host, port=port, timeout=TIMEOUT, retries=0)
