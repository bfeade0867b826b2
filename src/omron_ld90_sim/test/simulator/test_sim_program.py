"""Real sockets: the in-process simulator, fleets, the control socket and the program."""
from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import sys
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Iterator, List

import pytest
from sim_builders import ROOM

from omron_ld90_sim import Simulator
from omron_ld90_sim.interface.cli import main
from omron_ld90_sim.interface.faults import UnknownFault
from omron_ld90_sim.interface.fleet import FleetError, RobotSpec, read_fleet

PROGRAM = [sys.executable, '-c',
           'import sys; from omron_ld90_sim.interface.cli import main; sys.exit(main())']


@pytest.fixture
def map_file(tmp_path: Path) -> Path:
    path = tmp_path / 'room.map'
    path.write_text(ROOM)
    return path


class Talk:
    """A client on a socket; every wait is limited."""

    def __init__(self, port: int, password: str = 'adept') -> None:
        self.sock = socket.create_connection(('127.0.0.1', port), timeout=20.0)
        self._lines = self.sock.makefile('r', newline='\r\n', encoding='ascii')
        if password:
            self.send(password)
            self.until('End of commands')

    def send(self, line: str) -> None:
        self.sock.sendall(line.encode() + b'\r\n')

    def until(self, beginning: str) -> List[str]:
        seen = []
        while not seen or not seen[-1].startswith(beginning):
            line = self._lines.readline()
            assert line, f'closed before {beginning!r}, after {seen}'
            seen.append(line.rstrip('\r\n'))
        return seen

    def ended(self) -> bool:
        """Waits for the end of the connection."""
        try:
            return self._lines.read() == ''
        except ConnectionResetError:
            return True

    def close(self) -> None:
        self._lines.close()
        self.sock.close()


def to_the_end(sock: socket.socket, size: int = 4096) -> bytes:
    """Everything that comes until the connection ends."""
    return b''.join(iter(lambda: sock.recv(size), b''))


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    with socket.socket() as sock:
        sock.bind(('127.0.0.1', 0))
        sock.listen(4)
        sock.settimeout(20.0)
        yield sock


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
        with pytest.raises(OSError):    # dropped: what it sends then is answered with a reset
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
        gone.close()                    # with a reset, not with a good-bye
        assert other.until('Arrived')[-1] == 'Arrived at 12'


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
        with pytest.raises(UnknownFault):
            robot.inject('earthquake')


def test_a_map_on_the_robot_is_switched_to(map_file: Path) -> None:
    (map_file.parent / 'other.map').write_text(ROOM.replace('"West"', '"Occident"'))
    with Simulator(map_file) as robot, closing(Talk(robot.port)) as client:
        for line in ('configStart', 'configAdd Section Files', 'configAdd Map other.map',
                     'configParse'):
            client.send(line)
        assert client.until('Config ')[-4:] == ['Will parse config', 'Map changed',
                                                'Configuration changed', 'Config parsed fine']
        client.send('getGoals')
        assert 'Goal: Occident' in client.until('End of goals')
        for line in ('configStart', 'configAdd Section Files', 'configAdd Map ../room.map',
                     'configParse'):
            client.send(line)
        assert 'did not exist' in client.until('Config had')[-1]


def test_a_fleet_runs_in_one_process(map_file: Path) -> None:
    robots = [RobotSpec('a', 0), RobotSpec('b', 0), RobotSpec('c', 0, start=(0.0, 2000.0, 90.0))]
    with Simulator(map_file, speed=20.0, robots=robots) as fleet:
        talks = {name: Talk(port) for name, port in fleet.ports.items()}
        places = {(round(u.robot.true_pose.x), round(u.robot.true_pose.y)) for u in fleet.units}
        assert len(places) == 3 and (0, 2000) in places
        fleet.inject('@b estop press')
        talks['b'].until('EStop pressed')
        talks['a'].send('queryMotors')
        assert talks['a'].until('Motors')[-1] == 'Motors enabled'
        for talk in talks.values():
            talk.close()


@pytest.mark.parametrize('text, words', [
    ('robots: []', 'at least one robot'), ('robots: [{name: a}]', 'robot 1: has no port'),
    ('robots: [{port: 1, wings: 2}]', 'unknown field wings'), ('{', 'is not YAML'),
    ('robots: [{port: 70000}]', 'out of range'),
    ('robots: [{port: 7171}, {port: 7171}]', 'two robots have the port 7171'),
    ('robots: [{port: 1, outgoing: here}]', 'is not HOST:PORT'),
    ('robots: [{port: 1, start: [1, 2]}]', 'robot 1: ')])
def test_a_malformed_fleet_is_told_in_a_sentence(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / 'fleet.yaml'
    path.write_text(text)
    with pytest.raises(FleetError, match=words):
        read_fleet(str(path))


def test_the_program_serves_logs_takes_faults_and_ends_cleanly(map_file: Path) -> None:
    log = map_file.parent / 'session.log'
    password = map_file.parent / 'password'
    password.write_text('secret\n')
    program = subprocess.Popen(
        [*PROGRAM, '--map', str(map_file), '--port', '0', '--password-file', str(password),
         '--log', str(log), '--control', '0', '--start', '-3.0,1.5,0', '__name:=ld90_sim'],
        stdout=subprocess.PIPE, text=True, env={**os.environ, 'PYTHONUNBUFFERED': '1'})
    try:
        control = int(program.stdout.readline().rsplit(':', 1)[1])
        ready = program.stdout.readline()
        assert ready.startswith('ready: ARCL on 127.0.0.1:')
        client = Talk(int(ready.rsplit(':', 1)[1]), 'secret')
        with socket.create_connection(('127.0.0.1', control), timeout=20.0) as faults:
            faults.sendall(b'estop press\nearthquake\n')
            answers = faults.makefile()
            assert answers.readline() == 'ok\n'
            assert answers.readline().startswith("error: no fault 'earthquake'")
        assert client.until('EStop')[-1] == 'EStop pressed'
        program.send_signal(signal.SIGTERM)
        assert client.until('Shutting')[-1] == 'Shutting down server' and client.ended()
        client.close()
        assert program.wait(10.0) == 0
    finally:
        program.kill()
        program.communicate()
    text = log.read_text()
    assert 'C> ********' in text and 'secret' not in text and 'S> EStop pressed' in text


def refused(capsys: pytest.CaptureFixture, *arguments: str) -> str:
    assert main(list(arguments)) == 1
    captured = capsys.readouterr()
    assert captured.err.count('\n') == 1, captured.err
    return captured.err


def test_a_port_in_use_is_told_in_one_sentence(map_file: Path, listener: socket.socket,
                                               capsys: pytest.CaptureFixture) -> None:
    port = str(listener.getsockname()[1])
    error = refused(capsys, '--map', str(map_file), '--port', port)
    assert port in error and '--port' in error


@pytest.mark.parametrize('arguments, words', [
    ((), '--map'), (('--map', '/nowhere.map'), '/nowhere.map'),
    (('--password-file', '/nowhere'), '/nowhere'), (('--replay', '/nowhere'), '/nowhere'),
    (('--fault', 'earthquake'), 'earthquake'), (('--robots', '/nowhere'), '/nowhere'),
    (('--set', 'Docking/Wings=2'), 'Wings'), (('--start', '90,0,0'), 'outside the map')])
def test_what_cannot_be_done_is_told_in_one_sentence(map_file: Path, arguments: tuple, words: str,
                                                     capsys: pytest.CaptureFixture) -> None:
    given = list(arguments)
    if given and '--map' not in given:
        given = ['--map', str(map_file), '--port', '0', *given]
    assert words in refused(capsys, *given)


def test_the_program_serves_a_recorded_session_again(tmp_path: Path) -> None:
    log = tmp_path / 'session.log'
    log.write_text('0.0 S> Enter password:\n0.1 C> ********\n0.1 S> End of commands\n'
                   '2.0 C> goto 12\n2.1 S> Going to 12\n4.0 S> Arrived at 12\n')
    program = subprocess.Popen([*PROGRAM, '--replay', str(log), '--port', '0', '--speed', '20'],
                               stdout=subprocess.PIPE, text=True)
    try:
        with closing(Talk(int(program.stdout.readline().rsplit(':', 1)[1]))) as client:
            client.send('goto 12')
            assert client.until('Arrived') == ['Going to 12', 'Arrived at 12']
        program.terminate()
        assert program.wait(10.0) == 0
    finally:
        program.kill()
        program.communicate()


def test_a_simulation_that_ends_at_once_leaves_nothing_behind(map_file: Path) -> None:
    for _ in range(5):
        with Simulator(map_file) as robot:
            port = robot.port
        robot.stop()
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(('127.0.0.1', port), timeout=5.0)
