"""The door's process opens the door or says why it cannot. It ends with the page's process."""
from __future__ import annotations

import json
import os
import resource
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from dataclasses import asdict

import pytest

pytest.importorskip('aiohttp')

import door_opener  # noqa: E402
from door_opener import stop  # noqa: E402
from page_builders import PAGE_FOLDER, TOKENS, token_file  # noqa: E402

from fleet_page.door.connections import HEAD_WITHIN  # noqa: E402
from fleet_page.door.process import DoorError, DoorProcess, DoorSettings  # noqa: E402


@pytest.fixture
def door():
    process = DoorProcess(stop)
    yield process
    process.close()
    process.wait()


def settings(folder, **more) -> DoorSettings:
    return DoorSettings(**{'listen': '127.0.0.1', 'port': 0, 'worker': str(folder / 'socket'),
                           'files': str(PAGE_FOLDER), **more})


def post(port: int, content) -> dict:
    url = f'http://127.0.0.1:{port}'
    request = urllib.request.Request(f'{url}/api/act', json.dumps(content).encode(), {
        'Origin': url, 'Content-Type': 'application/json'})
    with urllib.request.urlopen(request, timeout=5.0) as answer:
        return dict(json.load(answer))


def test_the_door_stops_the_fleet_in_its_own_process_without_the_page(tmp_path, door):
    outcome = post(door.open(settings(tmp_path)), {'act': 'stop'})
    assert outcome['ok'] and f'process {os.getpid()},' not in outcome['text']


def test_the_door_ends_with_the_process_that_opened_it(tmp_path):
    process = DoorProcess(stop)
    port = process.open(settings(tmp_path))
    process.close()
    process.wait()
    with pytest.raises(OSError):
        socket.create_connection(('127.0.0.1', port), 1.0)


def test_the_thread_that_waits_for_the_door_counts_as_waiting_and_not_as_blocked(tmp_path):
    watchdog = pytest.importorskip('node_lifecycle.watchdog')
    process = DoorProcess(stop)
    process.open(settings(tmp_path))
    thread = threading.Thread(target=process.wait, name='door', daemon=True)
    thread.start()
    watch, end = watchdog.ThreadWatch(('fleet_page',), standstill=0.2), time.monotonic() + 1.0
    while time.monotonic() < end:
        assert [one for one in watch.blocked(time.monotonic()) if one.thread == 'door'] == []
        thread.join(0.1)
    process.close()
    thread.join(10.0)
    assert not thread.is_alive()


def test_a_door_that_was_never_opened_ends_too():
    process = DoorProcess(stop)
    process.close()
    process.wait()


@pytest.mark.parametrize('more, words', [
    ({'token_file': '/no/tokens'}, 'The token file /no/tokens cannot be read'),
    ({'certificate': '/no/certificate'}, 'The certificate .* cannot be used'),
    ({'listen': '192.0.2.1'}, 'cannot listen at 192.0.2.1, port 0')])
def test_a_door_that_cannot_open_says_why(tmp_path, door, more, words):
    with pytest.raises(DoorError, match=words):
        door.open(settings(tmp_path, **more))


def test_a_port_that_another_program_uses_is_told(tmp_path, door):
    with socket.socket() as other:
        other.bind(('127.0.0.1', 0))
        other.listen(1)
        with pytest.raises(DoorError, match='end the program that uses the port'):
            door.open(settings(tmp_path, port=other.getsockname()[1]))


def test_few_descriptors_are_enough_for_all_connections_that_the_limits_allow(tmp_path):
    """A flood never takes the descriptors that a STOP needs, even if only 1024 are allowed.

    The door must answer before it ends the first half request of the flood.
    """
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    opened = settings(tmp_path, token_file=token_file(tmp_path))
    flood = []
    with subprocess.Popen(
            [sys.executable, door_opener.__file__, '1024', json.dumps(asdict(opened))],
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(one for one in sys.path if one)},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE) as opener:
        assert opener.stdin is not None and opener.stdout is not None
        port = int(opener.stdout.readline())
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(before[1], 4096), before[1]))
        try:
            for number in range(1500):
                half = socket.socket()
                half.bind((f'127.0.3.{1 + number % 100}', 0))
                half.connect(('127.0.0.1', port))
                half.sendall(b'POST /api/act HTTP/1.1\r\n')
                flood.append(half)
            url = f'http://127.0.0.1:{port}'
            begun = time.monotonic()
            request = urllib.request.Request(
                f'{url}/api/login', json.dumps({'token': TOKENS['operate']}).encode(),
                {'Origin': url, 'Content-Type': 'application/json'})
            with urllib.request.urlopen(request, timeout=HEAD_WITHIN) as answer:
                assert answer.status == 200
            assert time.monotonic() - begun < 2.0
        finally:
            for half in flood:
                half.close()
            resource.setrlimit(resource.RLIMIT_NOFILE, before)
            opener.stdin.close()
