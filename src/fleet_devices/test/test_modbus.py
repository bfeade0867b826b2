"""A device behind Modbus TCP, against pymodbus's own server, and against servers that misbehave."""
from __future__ import annotations

import contextlib
import itertools
import socket
import threading
import time
from typing import Any, Callable, Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet_core.work.devices import HandOverAddress, ModbusAddress
from fleet_devices.core.device import Reading
from fleet_devices.core.hand_over import OFF, Signals, StartSignal
from fleet_devices.drivers import modbus
from fleet_devices.drivers.driver import Silent
from fleet_devices.drivers.modbus import (
    PAUSE,
    ModbusConnection,
    ModbusDevice,
    ModbusHandOver,
    unit_argument,
)

plc_module = pytest.importorskip(
    'plc', reason='pymodbus 3, or the module serial_asyncio that it needs, is not installed')
COIL, INPUT, UNIT, Plc = plc_module.COIL, plc_module.INPUT, plc_module.UNIT, plc_module.Plc


class Clock:
    """A clock that a test advances."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def device_at(address: ModbusAddress, clock: Callable[[], float] = time.monotonic) -> ModbusDevice:
    return ModbusDevice(ModbusConnection(address.host, address.port, clock), address)


@pytest.fixture
def plc() -> Iterator[Plc]:
    with Plc() as one:
        yield one


def test_the_output_is_set_and_left_and_both_bits_are_read(plc):
    door = device_at(plc.address)
    assert door.exchange(None) == Reading(False, False)
    assert door.exchange(True) == Reading(True, True)
    assert door.exchange(None) == Reading(True, True)
    assert plc.coils == {COIL: True}
    assert door.exchange(False) == Reading(False, False)


def test_a_device_that_lies_is_read_as_it_lies(plc):
    door = device_at(plc.address)
    plc.lies = True
    assert door.exchange(True) == Reading(True, False)
    plc.lies, plc.ignores = False, True
    assert door.exchange(False) == Reading(True, True)


def test_another_unit_is_not_read(plc):
    plc.coils[COIL] = True
    other = ModbusAddress('127.0.0.1', COIL, INPUT, plc.port, UNIT + 1)
    with pytest.raises(Silent):
        device_at(other).exchange(None)


def test_a_killed_server_is_silent_and_one_that_starts_again_is_read_again(plc):
    clock = Clock()
    door = device_at(plc.address, clock)
    assert door.exchange(True) == Reading(True, True)
    plc.kill()
    with pytest.raises(Silent, match='does not answer'):
        door.exchange(None)
    clock.now += PAUSE
    with pytest.raises(Silent, match='does not answer'):
        door.exchange(True)
    plc.start()
    with pytest.raises(Silent, match='does not answer'):
        door.exchange(True)  # no new connection is tried before the pause is over
    clock.now += PAUSE
    assert door.exchange(None) == Reading(False, False)  # the server has lost its coils
    assert door.exchange(True) == Reading(True, True)


def test_a_press_receives_the_key_with_its_start_and_says_how_it_has_ended(plc):
    press = ModbusHandOver(ModbusConnection('127.0.0.1', plc.port), plc.press)
    key = 2 ** 53 - 2
    assert press.exchange(None) == Signals(False, 0, False, False)
    assert press.exchange(StartSignal(True, key)) == Signals(True, key, False, False)
    plc.is_done = True
    assert press.exchange(None) == Signals(True, key, True, False)
    plc.is_done, plc.has_failed = False, True
    assert press.exchange(None) == Signals(True, key, False, True)
    assert press.exchange(OFF) == Signals(False, key, False, False)
    assert plc.starts == 1


def test_a_press_whose_server_dies_is_silent(plc):
    clock = Clock()
    press = ModbusHandOver(ModbusConnection('127.0.0.1', plc.port, clock), plc.press)
    press.exchange(StartSignal(True, 9))
    plc.kill()
    with pytest.raises(Silent, match='does not answer'):
        press.exchange(None)
    plc.start()
    clock.now += PAUSE
    assert press.exchange(None) == Signals(False, 0, False, False)  # the server has lost its memory
    assert plc.starts == 1


@contextlib.contextmanager
def server(answer: Callable[[bytes], bytes]) -> Iterator[ModbusAddress]:
    """A server that answers each piece of data with the bytes that a function gives."""
    with socket.create_server(('127.0.0.1', 0)) as listener:
        def serve() -> None:
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = listener.accept()
                    with connection:
                        while True:
                            data = connection.recv(1000)
                            if not data:
                                break
                            connection.sendall(answer(data))
        threading.Thread(target=serve, daemon=True).start()
        yield ModbusAddress('127.0.0.1', COIL, INPUT, listener.getsockname()[1], UNIT)
        listener.shutdown(socket.SHUT_RDWR)


def test_a_request_that_is_refused_keeps_the_connection():
    def refused(data: bytes) -> bytes:
        return data[:4] + b'\0\3' + data[6:7] + bytes((data[7] | 0x80, 2))
    with server(refused) as address:
        connection = ModbusConnection(address.host, address.port)
        door = ModbusDevice(connection, address)
        for output in (None, True):
            with pytest.raises(Silent, match='refuses the request'):
                door.exchange(output)
            assert connection._client is not None


def test_a_server_that_does_not_answer_ends_the_exchange(monkeypatch):
    monkeypatch.setattr(modbus, 'TIMEOUT', 0.2)
    with server(lambda data: b'') as address:
        begun = time.monotonic()
        with pytest.raises(Silent, match='does not answer'):
            device_at(address).exchange(True)
        assert time.monotonic() - begun < 5.0


@settings(max_examples=40, deadline=None)
@given(st.lists(st.binary(max_size=300), min_size=1, max_size=4))
def test_no_bytes_upset_the_driver(answers):
    """Whatever a server sends, the exchange returns a reading, or raises Silent."""
    given_ = iter(answers * 100)

    def answer(data: bytes) -> bytes:
        body = next(given_)
        if len(body) % 2:  # the right header, so that the rest is read
            return data[:4] + len(body).to_bytes(2, 'big') + body
        return body
    before, modbus.TIMEOUT = modbus.TIMEOUT, 0.05
    try:
        with server(answer) as address:
            connection = ModbusConnection(address.host, address.port, itertools.count().__next__)
            door = ModbusDevice(connection, address)
            with contextlib.suppress(Silent):
                reading = door.exchange(True)
                assert all(isinstance(bit, bool) for bit in reading)
            connection.close()
            press = ModbusHandOver(connection, HandOverAddress('127.0.0.1', 1, 2, 3, 4))
            with contextlib.suppress(Silent):
                signals = press.exchange(StartSignal(True, 2 ** 40))
                assert 0 <= signals.key < 2 ** 64
            connection.close()
    finally:
        modbus.TIMEOUT = before


@pytest.mark.parametrize('names, expected', [
    ('address, count=1, **kwargs', {'unit': 5}),                 # 2.x
    ('address, count=1, slave=0, **kwargs', {'slave': 5}),       # 3.0 to 3.9
    ('address, *, count=1, device_id=1', {'device_id': 5})])     # from 3.10 on
def test_the_unit_is_named_as_each_version_names_it(names, expected):
    scope: Any = {}
    exec(f'def method({names}): pass', scope)  # noqa: S102 the text is of this test
    assert unit_argument(scope['method'], 5) == expected
