"""Tests of the host and of `hosted`, which run as processes. Their parent is this process, not
roslaunch.
"""
from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from node_host.address import host_address

PACKAGE = Path(__file__).resolve().parents[1]
SOURCES = PACKAGE.parent

pytestmark = pytest.mark.skipif(not shutil.which('cc') or not hasattr(signal, 'pthread_sigmask'),
                                reason='no C compiler')


@pytest.fixture(scope='module')
def hosted(tmp_path_factory):
    program = tmp_path_factory.mktemp('bin') / 'hosted'
    subprocess.run(['cc', '-std=gnu99', '-o', program, PACKAGE / 'src' / 'hosted.c'], check=True)
    return program


class Launch:
    """A host, and programs that run as forks of it."""

    def __init__(self, folder, hosted):
        self.folder, self._hosted = folder, hosted
        self._processes = []
        self._environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(
            str(SOURCES / name / 'src') for name in ('node_host', 'node_lifecycle'))}

    def host(self, *modules, before=''):
        """Starts a host in a new process, which first runs the code `before`."""
        code = f"{before}\nfrom node_program import run_main; run_main('node_host.program')"
        return self._popen([sys.executable, '-c', code, *modules])

    def run(self, code, *arguments, environment=None, folder=None):
        """Starts `hosted` with a program."""
        program = self.folder / f'program{len(self._processes)}'
        program.write_text('#!/usr/bin/env python3\nimport os, signal, sys, time\n' + code)
        return self._popen([self._hosted, program, *arguments], environment, folder)

    def _popen(self, command, environment=None, folder=None):
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder,
            env={**self._environment, **(environment or {})}, start_new_session=True)
        self._processes.append(process)
        return process

    def close(self):
        for process in self._processes:
            if process.poll() is None:
                process.kill()
            process.communicate()


@pytest.fixture
def launch(tmp_path, hosted):
    one = Launch(tmp_path, hosted)
    yield one
    one.close()


def result(process):
    output, errors = process.communicate(timeout=30.0)
    return process.returncode, output, errors


def until(condition):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def is_there(pid):
    """Returns whether the process runs. A process that has ended does not run, even if no process
    has waited for it: in a container, the first process may wait only for its own children.
    """
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except (FileNotFoundError, ProcessLookupError):
        return False


SAYS_ITS_PID = 'print(os.getpid(), flush=True)\n'
RUNS_ON = SAYS_ITS_PID + 'time.sleep(60.0)'


def pid_of(process):
    return int(process.stdout.readline())


def test_a_program_has_its_own_arguments_folder_environment_streams_and_status(launch, tmp_path):
    launch.host()
    program = launch.run(
        "print(sys.argv[1:], os.getcwd(), os.environ['GIVEN'], __name__)\n"
        "print('wrong', file=sys.stderr)\nsys.exit(7)",
        '', 'a b', '__name:=x', environment={'GIVEN': 'here'}, folder=tmp_path)
    assert result(program) == (
        7, f"['', 'a b', '__name:=x'] {tmp_path} here __main__\n", 'wrong\n')


def test_modules_are_imported_once_and_one_that_is_missing_is_told(launch):
    host = launch.host('decimal', 'no_such_module')
    program = launch.run("print('decimal' in sys.modules)")
    assert result(program)[:2] == (0, 'True\n')
    host.terminate()
    assert 'no_such_module cannot be imported' in result(host)[2]


def test_a_fork_holds_nothing_of_the_host_open_and_has_one_thread(launch):
    launch.host('numpy')
    launch.run(RUNS_ON)
    program = launch.run("print(sorted(map(int, os.listdir('/proc/self/fd')))[:-1],"
                         " len(os.listdir('/proc/self/task')))")
    status, output, _ = result(program)
    assert status == 0
    assert output == '[0, 1, 2, 3] 1\n'  # descriptor 3 reports that the program has started


def test_a_crash_ends_one_program_with_its_traceback_and_no_other(launch):
    host, other = launch.host(), launch.run(RUNS_ON)
    status, _, errors = result(launch.run("raise KeyError('gone')"))
    assert status == 1
    assert "KeyError: 'gone'" in errors
    assert is_there(pid_of(other))
    assert host.poll() is None


def test_a_signal_that_ends_a_program_ends_its_hosted_too(launch):
    launch.host()
    for number in (signal.SIGKILL, signal.SIGSEGV):
        assert result(launch.run(f'os.kill(os.getpid(), {int(number)})'))[0] == -number


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_signals_are_passed_on(launch, number):
    launch.host()
    program = launch.run(f'signal.signal({int(number)}, lambda *_: sys.exit(5))\n' + RUNS_ON)
    pid_of(program)
    program.send_signal(number)
    assert result(program)[0] == 5


def test_a_signal_right_after_the_start_is_not_lost(launch):
    launch.host()
    programs = [launch.run('time.sleep(60.0)') for _ in range(10)]
    for program in programs:
        time.sleep(0.003)
        program.terminate()
    assert [result(program)[0] for program in programs] == [-signal.SIGTERM] * 10


def test_kill_9_of_hosted_ends_its_program(launch):
    launch.host()
    program = launch.run(RUNS_ON)
    pid = pid_of(program)
    program.kill()
    until(lambda: not is_there(pid))


def test_a_host_that_is_killed_takes_its_programs_along_and_a_new_one_starts_them(launch):
    host, program = launch.host(), launch.run(RUNS_ON)
    pid = pid_of(program)
    host.kill()
    assert result(program)[0] == 1
    until(lambda: not is_there(pid))
    again = launch.run('print("again")')  # this program waits for a new host
    launch.host()
    assert result(again)[:2] == (0, 'again\n')


def test_ctrl_c_of_the_host_ends_its_programs_in_order(launch):
    host = launch.host()
    program = launch.run('signal.signal(signal.SIGINT, lambda *_: sys.exit(6))\n' + RUNS_ON)
    pid_of(program)
    host.send_signal(signal.SIGINT)
    assert result(program)[0] == 6
    assert result(host)[0] == 0


def test_ctrl_c_ends_a_hosted_that_waits_for_its_host(launch):
    waits = launch.run('pass')
    time.sleep(0.1)
    waits.send_signal(signal.SIGINT)
    assert result(waits)[0] == -signal.SIGINT


def test_a_fork_that_fails_is_told_and_the_rest_starts(launch):
    host = launch.host(before="""
import errno, os
fork, tries = os.fork, []
def fails_once():
    tries.append(1)
    if len(tries) == 1:
        raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))
    return fork()
os.fork = fails_once""")
    status, _, errors = result(launch.run('pass'))
    assert status == 1
    assert 'cannot be started: fork: Resource temporarily unavailable' in errors
    assert result(launch.run("print('runs')"))[:2] == (0, 'runs\n')
    assert host.poll() is None


def test_a_low_limit_of_open_files_limits_no_host(launch):
    launch.host(before="""
import resource
resource.setrlimit(resource.RLIMIT_NOFILE, (16, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))""")
    assert all(pid_of(program) for program in [launch.run(RUNS_ON) for _ in range(12)])


def test_a_program_that_cannot_be_read_is_told_with_its_name(launch, tmp_path):
    launch.host()
    program = launch.run('pass')
    result(program)
    (tmp_path / 'program1').unlink()
    lacks = launch._popen([launch._hosted, tmp_path / 'program1'])
    status, _, errors = result(lacks)
    assert status == 1
    assert 'program1' in errors


def test_a_program_is_listed_with_its_own_command_line(launch):
    launch.host(*['json'] * 40)
    program = launch.run(RUNS_ON, '__name:=controller')
    process = Path(f'/proc/{pid_of(program)}')
    own = str(launch.folder / 'program1')
    assert (process / 'cmdline').read_text().rstrip('\0').split('\0') == [own, '__name:=controller']
    assert (process / 'comm').read_text() == 'program1\n'


def test_a_launch_has_one_host_only(launch):
    launch.host()
    assert result(launch.run("print('up')"))[0] == 0
    status, _, errors = result(launch.host())
    assert status == 1
    assert 'has a node host already' in errors


NOBODY = 65534
root_only = pytest.mark.skipif(os.geteuid() != 0, reason='only root can be another user, too')


class OtherUser:
    """A process of another user: a child of this process, like the host and its programs."""

    def __init__(self, work):
        reader, writer = os.pipe()
        self._pid = os.fork()
        if self._pid == 0:
            try:
                os.setresuid(NOBODY, NOBODY, NOBODY)
                with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as end:
                    end.settimeout(20.0)
                    work(end, lambda said: os.write(writer, said + b'\n'))
            finally:
                os._exit(0)
        os.close(writer)
        self.said = os.fdopen(reader, 'rb')

    def close(self):
        self.said.close()
        os.waitpid(self._pid, 0)


@root_only
def test_a_host_starts_nothing_for_another_user(launch):
    launch.host()
    assert result(launch.run("print('up')"))[0] == 0

    def ask(end, say):
        end.connect(host_address())
        say(end.recv(1) or b'refused')

    other = OtherUser(ask)
    assert other.said.readline() == b'refused\n'
    other.close()
    assert result(launch.run("print('up')"))[:2] == (0, 'up\n')


@root_only
def test_a_program_uses_no_host_of_another_user(launch):
    def serve(end, say):
        end.bind(host_address())
        end.listen(1)
        say(b'ready')
        connection, _ = end.accept()
        say(connection.recv(10000) or b'nothing')

    other = OtherUser(serve)
    other.said.readline()
    status, output, errors = result(launch.run("print('up')"))
    assert (status, output) == (1, '')
    assert 'belongs to another user' in errors
    assert other.said.readline() == b'nothing\n'
    other.close()


def test_random_numbers_of_two_programs_differ(launch):
    launch.host('random', 'numpy.random')
    code = 'import random, numpy\nprint(random.random(), numpy.random.random())'
    first, second = (result(launch.run(code))[1].split() for _ in range(2))
    assert first[0] != second[0]
    assert first[1] != second[1]
