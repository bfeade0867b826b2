"""The program: its services, and its error messages."""
from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from sim_client import Talk

from omron_ld90_sim.interface.cli import main

PROGRAM = [sys.executable, '-c',
           'import sys; from omron_ld90_sim.interface.cli import main; sys.exit(main())']


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
            faults.sendall(b'where\n')
            place = json.loads(answers.readline())
            assert place['time'] > 0.0
            assert place['robots'] == {
                'robot': {'x': -3.0, 'y': 1.5, 'heading': 0.0, 'driven': 0.0}}
            faults.sendall(b'speed 20\nspeed nan\n')
            assert answers.readline() == 'ok\n'
            assert answers.readline() == "error: 'nan' is not a number from 0.1 to 20\n"
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


@pytest.mark.parametrize('option', ['--speed nan', '--battery nan', '--battery 101', '--port -1',
                                    '--start 0,0,nan', '--start 0,0', '--arrival-error nan,1',
                                    '--outgoing-commands inf:Status', '--outgoing here'])
def test_a_wrong_option_is_told_with_what_it_takes(option: str, capsys: pytest.CaptureFixture
                                                   ) -> None:
    with pytest.raises(SystemExit) as end:
        main(['--map', 'room.map', *option.split()])
    assert end.value.code == 2
    assert f'argument {option.split()[0]}: ' in capsys.readouterr().err
