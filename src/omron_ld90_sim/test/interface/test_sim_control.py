"""The control socket of a running simulation obeys programs, but not web pages."""
from __future__ import annotations

import socket
from typing import Iterator

import pytest

from omron_ld90_sim import Simulator

REQUEST = b'\r\nHost: 127.0.0.1\r\nOrigin: http://evil.example\r\n\r\n'


@pytest.fixture(name='robot')
def _robot(map_file) -> Iterator[Simulator]:
    with Simulator(map_file) as simulator:
        yield simulator


def answer(port: int, data: bytes, lines: int) -> bytes:
    """Sends data. Returns the answer: `lines` lines, or fewer if the connection ends."""
    received = b''
    with socket.create_connection(('127.0.0.1', port), timeout=20.0) as connection:
        connection.sendall(data)
        try:
            while received.count(b'\n') < lines:
                piece = connection.recv(65536)
                if not piece:
                    break
                received += piece
        except ConnectionResetError:
            pass
    return received


def controlled(robot: Simulator) -> int:
    ports = []
    robot._in_loop(lambda: ports.append(robot.control_on(0)))
    return ports[0]


def test_each_line_of_a_program_is_answered(robot):
    first, second, third = answer(controlled(robot), b'speed 3\nnonsense\nwhere\n', 3).splitlines()
    assert first == b'ok'
    assert second.startswith(b'error: ')
    assert third.startswith(b'{')
    assert robot.loop.speed == 3.0


@pytest.mark.parametrize('first', [b'POST / HTTP/1.1', b'OPTIONS * HTTP/1.1', b'speed / HTTP/1.0',
                                   b'GET /' + 3000 * b'a' + b' HTTP/1.1',
                                   b'GET /' + 9000 * b'a' + b' HTTP/1.1'], ids=len)
def test_a_web_page_changes_nothing_and_reads_nothing(robot, first):
    assert answer(controlled(robot), first + REQUEST + b'speed 7\nwhere\n', 9) == b''
    assert robot.loop.speed == 1.0


def test_a_web_page_that_knows_the_password_drives_no_simulated_robot(robot):
    said = answer(robot.port, b'POST / HTTP/1.1' + REQUEST + b'adept\ngoto 1\n', 99)
    assert b'Going to' not in said and b'Welcome' not in said
    assert robot.where()  # the simulation still runs
