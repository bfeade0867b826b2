"""Real sockets: clients, the outgoing connection, and their ends."""
from __future__ import annotations

import errno
import socket
import struct
import threading
import time
from contextlib import ExitStack, closing
from pathlib import Path
from typing import List

import pytest
from sim_client import Talk, to_the_end

from omron_ld90_sim import Simulator
from omron_ld90_sim.interface.faults import NoSuchFault


def test_a_client_drives_the_robot_over_tcp(map_file: Path) -> None:
    with Simulator(map_file, speed=20.0, arrival_error=(0.0, 0.0)) as robot, \
            closing(Talk(robot.port)) as client:
        client.send('goto 12')
        assert client.until('Arrived')[-2:] == ['Going to 12', 'Arrived at 12']
        assert robot.pose[:2] == pytest.approx((4500.0, -2000.0), abs=1.0)
        client.send('quit')
        assert client.until('Closing')[-1] == 'Closing connection' and client.ended()


def test_a_wrong_password_ends_the_connection(map_file: Path) -> None:
    with Simulator(map_file) as robot, closing(Talk(robot.port, '')) as client:
        client.until('Enter password:')
        client.send('wrong')
        assert client.ended()


def test_a_telnet_library_logs_in_asks_drives_and_leaves(map_file: Path) -> None:
    telnetlib = pytest.importorskip('telnetlib', reason='Python from 3.13 on has none')
    with Simulator(map_file, speed=20.0, start=(-3000.0, 0.0, 0.0)) as robot:
        telnet = telnetlib.Telnet('127.0.0.1', robot.port, timeout=20.0)

        def until(end: str) -> str:
            text = telnet.read_until(end.encode() + b'\r\n', timeout=20.0).decode('ascii')
            assert text.endswith(end + '\r\n'), text
            return text

        def ask(command: str, end: str) -> str:
            telnet.write(command.encode() + b'\n')
            return until(end)

        until('Enter password:')
        login = ask('adept', 'End of commands')
        assert login == ('Welcome to the server.\r\nYou can type \'help\' at any time for the '
                         'following help list.\r\n' + ask('help', 'End of commands'))
        status = ask('status', 'Temperature: 36').splitlines()
        assert [line.split(':')[0] for line in status] == [
            'ExtendedStatusForHumans', 'Status', 'StateOfCharge', 'Location', 'LocalizationScore',
            'Temperature']
        assert 'Location: -3000 0 0' in status
        assert ask('goto 12', 'Arrived at 12') == 'Going to 12\r\nArrived at 12\r\n'
        assert 'Status: Arrived at 12' in ask('status', 'Temperature: 36')
        assert ask('quit', 'Closing connection') == 'Closing connection\r\n'
        assert telnet.read_all() == b''
        telnet.close()


def test_a_login_reads_the_same_byte_by_byte(map_file: Path) -> None:
    with Simulator(map_file) as robot:
        seen = []
        for size in (1, 2048):
            with socket.create_connection(('127.0.0.1', robot.port), timeout=20.0) as client:
                client.sendall(b'adept\rquit\r')
                seen.append(to_the_end(client, size))
    assert seen[0] == seen[1] and seen[0].endswith(b'Closing connection\r\n')


def test_a_client_that_ends_its_sending_half_still_gets_its_answers(map_file: Path) -> None:
    with Simulator(map_file) as robot, \
            socket.create_connection(('127.0.0.1', robot.port), timeout=20.0) as client:
        client.sendall(b'adept\nhelp\nqueryMotors\n')
        client.shutdown(socket.SHUT_WR)
        answer = to_the_end(client)
    assert answer.count(b'End of commands\r\n') == 2
    assert answer.endswith(b'Motors enabled\r\n')


def test_a_client_that_never_reads_holds_nobody_up_and_is_dropped(
        map_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('omron_ld90_sim.interface.transport.MAX_OUTPUT', 100_000)
    with Simulator(map_file, speed=20.0) as robot, closing(Talk(robot.port)) as other:
        deaf = socket.socket()
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.settimeout(20.0)
        deaf.connect(('127.0.0.1', robot.port))
        deaf.sendall(b'adept\n')
        other.send('goto 12')
        with pytest.raises(OSError):  # the server has dropped this client: its data cause a reset
            for _ in range(100_000):
                deaf.sendall(b'help\n' * 10)
        deaf.close()
        assert other.until('Arrived')[-1] == 'Arrived at 12'


def test_a_delayed_farewell_comes_before_the_end(map_file: Path) -> None:
    with Simulator(map_file) as robot, closing(Talk(robot.port)) as client:
        robot.inject('delay 0.2')
        client.send('quit')
        assert client.until('Closing') == ['Closing connection'] and client.ended()


def test_many_clients_at_once_each_get_their_own_answers(map_file: Path) -> None:
    with Simulator(map_file) as robot, ExitStack() as stack:
        clients = [stack.enter_context(closing(Talk(robot.port))) for _ in range(20)]
        for number, client in enumerate(clients):
            client.send(f'createInfo client{number} 9 {number}\r\ngetInfo client{number}\r\nquit')
        for number, client in enumerate(clients):
            assert client.until('Closing') == [
                f'Created info for client{number}', f'Info: client{number} {number}',
                'Closing connection']
            assert client.ended()


def test_a_client_that_vanishes_leaves_the_robot_driving(map_file: Path) -> None:
    with Simulator(map_file, speed=20.0) as robot, closing(Talk(robot.port)) as other:
        gone = Talk(robot.port)
        gone.send('goto 12')
        gone.until('Going to 12')
        gone.sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
        gone.close()  # with a reset instead of a regular close
        assert other.until('Arrived')[-1] == 'Arrived at 12'


def test_a_program_without_a_free_file_descriptor_waits_before_it_listens_again(
        map_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused = threading.Event()
    calls: List[socket.socket] = []

    def accept(listener: socket.socket) -> None:
        calls.append(listener)
        refused.set()
        raise OSError(errno.EMFILE, 'Too many open files')

    with Simulator(map_file) as robot:
        with monkeypatch.context() as full:
            full.setattr(socket.socket, 'accept', accept)
            with closing(socket.socket()) as client:
                # the port may close before this call has finished
                client.connect_ex(('127.0.0.1', robot.port))
                assert refused.wait(20.0)
                for _ in range(20):
                    robot.inject('unblock')  # each call takes a cycle of the loop
        assert len(calls) == 1
        with closing(connected(robot.port)) as client:
            client.send('queryMotors')
            assert client.until('Motors')[-1] == 'Motors enabled'


def connected(port: int) -> Talk:
    """Waits until the port is open. Returns a client that is connected to it."""
    end = time.monotonic() + 20.0
    while True:
        try:
            return Talk(port)
        except ConnectionError:
            assert time.monotonic() < end, 'the port stays closed'
            time.sleep(0.02)


def test_the_robot_dials_out_and_dials_again(map_file: Path, listener: socket.socket) -> None:
    with Simulator(map_file, speed=20.0, outgoing=listener.getsockname()):
        for _ in range(2):
            link, _ = listener.accept()
            with link, link.makefile('r', newline='\r\n') as lines:
                seen = [lines.readline() for _ in range(7)]
            assert seen[0].startswith('ExtendedStatusForHumans: ')
            assert seen[5].startswith('Temperature: ')
            assert seen[6].startswith('RangeDeviceGetCurrent: Laser_1 ')


def test_a_fault_ends_connections_and_refuses_new_ones(map_file: Path) -> None:
    with Simulator(map_file) as robot, closing(Talk(robot.port)) as client:
        robot.inject('refuse on')
        robot.inject('reset')
        assert client.ended()
        with pytest.raises(ConnectionRefusedError):
            Talk(robot.port)
        robot.inject('refuse off')
        Talk(robot.port).close()
        with pytest.raises(NoSuchFault):
            robot.inject('earthquake')
