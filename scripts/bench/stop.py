#!/usr/bin/env python3
"""Measures how fast STOP of the fleet page answers while everything else disturbs it.

The real node and its door run under a separate ROS master, once without TLS and once with TLS. A
service in place of the fleet manager accepts the stops. Each stop uses a new connection. The
attackers and the fleet page share this computer's cores. It takes about four minutes.
"""
from __future__ import annotations

import argparse
import http.client
import json
import multiprocessing
import os
import resource
import selectors
import signal
import socket
import ssl
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib
from collections import deque
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np
import rospy
from measuring.processes import descendants, proportional
from measuring.ros_master import own_ros_master
from measuring.tables import Row, print_table
from nav_msgs.msg import OccupancyGrid
from std_srvs.srv import Trigger, TriggerResponse

from ports import free_port

ROOT = Path(__file__).resolve().parents[2]
TOKENS = {'operate': 'a-token-that-operates', 'see': 'a-token-that-only-sees'}
OWN = '127.0.0.1'
HALF_OPEN = 20_000
HALF_REQUESTS = {False: b'POST /api/act HTTP/1.1\r\nHost: 127.0.0.1',
                 True: b'\x16\x03\x01\x02\x00\x01\x00'}  # the beginning of a TLS handshake
OPENED_EACH_SECOND = 2000  # number of half (incomplete) requests, of all attackers together
IP_BIND_ADDRESS_NO_PORT = 24  # an option of Linux that has no name in the module socket
ATTACKERS = 2         # processes, because each process may open only a limited number of files
SEERS = 40
STOPS = 30
PERIOD = 0.25         # s between two stops; the page refuses stops at a higher rate
WITHIN = 200.0        # ms, the aim
MAP = 10_000          # cells along each side
BOMB = 30_000_000     # bytes of a body before its compression


class Page:
    """The page, for a program on this computer."""

    def __init__(self, port: int, trust: Optional[ssl.SSLContext]) -> None:
        self.port, self.trust = port, trust
        self.origin = f'{"https" if trust else "http"}://127.0.0.1:{port}'

    def open(self, address: str = OWN) -> http.client.HTTPConnection:
        """Returns a new connection from an address of this computer."""
        more: Dict[str, Any] = {'timeout': 10.0, 'source_address': (address, 0)}
        if self.trust is not None:
            return http.client.HTTPSConnection('127.0.0.1', self.port, context=self.trust, **more)
        return http.client.HTTPConnection('127.0.0.1', self.port, **more)

    def post(self, path: str, content: Any, cookie: str = '') -> Tuple[int, str, Any]:
        """Posts JSON on a new connection. Returns status, cookie and answer."""
        connection = self.open()
        try:
            connection.request('POST', path, json.dumps(content), {
                'Origin': self.origin, 'Content-Type': 'application/json', 'Cookie': cookie})
            answer = connection.getresponse()
            given = (answer.getheader('Set-Cookie') or '').partition(';')[0]
            return answer.status, given, json.loads(answer.read())
        finally:
            connection.close()

    def login(self, role: str) -> str:
        """Returns the cookie of a new session."""
        status, cookie, answer = self.post('/api/login', {'token': TOKENS[role]})
        assert status == 200, answer
        return cookie


def stop_times(page: Page, cookie: str) -> List[float]:
    """Returns the times (ms) of all stops."""
    times = []
    for _ in range(STOPS):
        begun = time.monotonic()
        status, _, answer = page.post('/api/act', {'act': 'stop'}, cookie)
        times.append(1e3 * (time.monotonic() - begun))
        assert status == 200 and answer['ok'], answer
        time.sleep(PERIOD)
    return times


# -- disturbances ----------------------------------------------------------------------------------

def hold_half_open(port: int, half_request: bytes, count: int, addresses: Sequence[str],
                   opened: Any) -> None:
    """Sends `count` requests that stay incomplete, and holds their connections open.

    Opens a new connection for each one that the page ends. The rate of new connections is limited.
    """
    os.nice(10)  # real attackers run on other computers, and use no CPU time here
    selector = selectors.EpollSelector()
    waiting, begun, added = deque(range(count)), time.monotonic(), 0

    def add(number: int) -> None:
        half = socket.socket()
        half.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
        half.setsockopt(socket.IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, 1)
        half.bind((addresses[number % len(addresses)], 0))
        half.setblocking(False)
        half.connect_ex(('127.0.0.1', port))
        selector.register(half, selectors.EVENT_WRITE, number)
    while True:
        due = (time.monotonic() - begun) * OPENED_EACH_SECOND / ATTACKERS
        while waiting and added < due:
            add(waiting.popleft())
            added += 1
        added = max(added, int(due) - 100)  # after a delay, at most 100 half requests are due
        for key, events in selector.select(0.005):
            half = key.fileobj
            assert isinstance(half, socket.socket)
            try:
                if events & selectors.EVENT_WRITE:
                    half.send(half_request)
                    selector.modify(half, selectors.EVENT_READ, key.data)
                    with opened.get_lock():
                        opened.value += 1
                    continue
                if half.recv(1000):
                    continue
            except OSError:
                pass  # the page has ended the connection
            selector.unregister(half)
            half.close()
            waiting.append(key.data)


@contextmanager
def half_open(page: Page, addresses: Sequence[str]) -> Iterator[Callable[[], str]]:
    """Runs attackers at these addresses, in separate processes."""
    opened = multiprocessing.Value('q', 0)
    args = (page.port, HALF_REQUESTS[page.trust is not None], HALF_OPEN // ATTACKERS, addresses,
            opened)
    programs = [multiprocessing.Process(target=hold_half_open, args=args, daemon=True)
                for _ in range(ATTACKERS)]
    for program in programs:
        program.start()
    try:
        while opened.value < HALF_OPEN:
            time.sleep(0.05)
        begun, before = time.monotonic(), opened.value
        yield lambda: f'{(opened.value - before) / (time.monotonic() - begun):.0f} opened a second'
    finally:
        for program in programs:
            program.kill()
            program.join()


def repeat_all(makers: Sequence[Callable[[], Callable[[], None]]], done: Any) -> None:
    """Makes clients, and repeats the work of each in a thread of its own, without an end."""
    os.nice(10)  # as in hold_half_open

    def repeat(work: Callable[[], None]) -> None:
        while True:
            try:
                work()
                with done.get_lock():
                    done.value += 1
            except (OSError, http.client.HTTPException):
                pass  # the door ends and refuses some of them
            time.sleep(0.02)
    running = [threading.Thread(target=repeat, args=(make(),)) for make in makers]
    for thread in running:
        thread.start()
    for thread in running:
        thread.join()


@contextmanager
def clients(makers: Sequence[Callable[[], Callable[[], None]]]) -> Iterator[Callable[[], str]]:
    """Runs clients in a separate process, and counts their work."""
    done = multiprocessing.Value('q', 0)
    program = multiprocessing.Process(target=repeat_all, args=(makers, done), daemon=True)
    program.start()
    try:
        while not done.value:
            time.sleep(0.05)
        begun, before = time.monotonic(), done.value
        yield lambda: f'{(done.value - before) / (time.monotonic() - begun):.0f} rounds a second'
    finally:
        program.kill()
        program.join()


def seer(page: Page, cookie: str, number: int) -> Callable[[], None]:
    """Returns a client that follows the fleet and asks for site and history again and again."""
    address = f'127.0.4.{number + 1}'
    stream = page.open(address)
    stream.request('GET', '/api/events', headers={'Cookie': cookie})
    stream.getresponse()

    def work() -> None:
        connection = page.open(address)
        try:
            for path in ('/api/site', f'/api/history?hours={100 + number}', '/api/replay'):
                connection.request('GET', path, headers={'Cookie': cookie})
                connection.getresponse().read()
        finally:
            connection.close()
    return work


def bomber(page: Page, number: int) -> Callable[[], None]:
    """Returns a client without a login that sends compressed bodies."""
    body = zlib.compress(bytes(BOMB))

    def work() -> None:
        connection = page.open(f'127.0.5.{number + 1}')
        try:
            connection.request('POST', '/api/login', body, {
                'Origin': page.origin, 'Content-Type': 'application/json',
                'Content-Encoding': 'deflate'})
            status = connection.getresponse().status
            assert status == 415, status
        finally:
            connection.close()
    return work


@contextmanager
def huge_map(topic: rospy.Publisher) -> Iterator[Callable[[], str]]:
    """Publishes a map of 100,000,000 cells."""
    message = OccupancyGrid()
    message.info.width = message.info.height = MAP
    message.info.resolution = 0.05
    message.data = np.zeros(MAP * MAP, np.int8).tobytes()
    topic.publish(message)
    yield lambda: f'{MAP} x {MAP} cells'


@contextmanager
def hanging(program: int) -> Iterator[Callable[[], str]]:
    """Stops the page's process without a notice to the door."""
    os.kill(program, signal.SIGSTOP)
    try:
        yield lambda: 'SIGSTOP'
    finally:
        os.kill(program, signal.SIGCONT)


@contextmanager
def nothing() -> Iterator[Callable[[], str]]:
    """Disturbs nothing."""
    yield str


# -- the page --------------------------------------------------------------------------------------

@contextmanager
def node(port: int, folder: Path, pair: Tuple[str, ...]) -> Iterator[subprocess.Popen]:
    """Starts the node. Yields its process when the door answers."""
    tokens = folder / 'tokens'
    tokens.write_text(''.join(f'{role} {role}r {token}\n' for role, token in TOKENS.items()))
    tokens.chmod(0o600)
    program = subprocess.Popen(
        [sys.executable, str(ROOT / 'src/fleet_page/nodes/fleet_page'), f'_port:={port}',
         f'_folder:={folder}', f'_journal:={folder}/none.sqlite', f'_token_file:={tokens}', *pair],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 30.0
        while True:
            try:
                socket.create_connection(('127.0.0.1', port), 1.0).close()
                break
            except OSError:
                assert time.monotonic() < deadline, 'the page does not answer'
                time.sleep(0.1)
        yield program
    finally:
        program.terminate()
        program.wait(20)


def certificate(folder: Path) -> Tuple[str, str]:
    """Makes a certificate for this computer. Returns the files of the certificate and its key."""
    files = str(folder / 'page.pem'), str(folder / 'page.key')
    subprocess.run(
        ['openssl', 'req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1',
         '-nodes', '-days', '2', '-subj', '/CN=localhost', '-addext', 'subjectAltName=IP:127.0.0.1',
         '-out', files[0], '-keyout', files[1]], check=True, stderr=subprocess.DEVNULL)
    os.chmod(files[1], 0o600)
    return files


def figures(page: Page, program: int, map_topic: rospy.Publisher) -> Iterator[Row]:
    """Yields the rows for one case: the page with or without TLS."""
    operator, see = page.login('operate'), page.login('see')
    many = [f'127.0.3.{number + 1}' for number in range(200)]
    scheme = page.origin.partition(':')[0]
    ways: List[Tuple[str, Callable[[], Any]]] = [
        ('nothing else', nothing),
        (f'{HALF_OPEN} half requests of one other address',
         lambda: half_open(page, ['127.0.0.9'])),
        (f'{HALF_OPEN} half requests of 200 addresses', lambda: half_open(page, many)),
        (f'{HALF_OPEN} half requests of the own address',
         lambda: half_open(page, [OWN])),
        (f'{SEERS} clients of role see', lambda: clients(
            [partial(seer, page, see, number) for number in range(SEERS)])),
        ('20 clients with compressed bodies', lambda: clients(
            [partial(bomber, page, number) for number in range(20)])),
        ('a huge map', lambda: huge_map(map_topic)),
        ('the page hangs', lambda: hanging(program))]
    floor = ''
    for name, way in ways:
        with way() as told:
            try:
                times = stop_times(page, operator)
            except (OSError, http.client.HTTPException) as error:
                yield Row(f'{scheme}: {name}, {told()}', f'not answered ({error!r})', floor)
                continue
            figure = f'p50 {statistics.median(times):.1f} ms, longest {max(times):.1f} ms'
            missed = '' if max(times) < WITHIN else ': **missed**'
            yield Row(f'{scheme}: {name}' + (f', {told()}' if told() else ''), figure, floor,
                      f'< {WITHIN:.0f} ms{missed}')
            floor = floor or figure
    door, = descendants(program)
    yield Row(f'{scheme}: memory (PSS) of the door, at the end',
              f'{proportional(door) / 1e6:.0f} MB')


def main() -> None:
    """Prints the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    os.environ.setdefault('ROS_IP', '127.0.0.1')
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    with tempfile.TemporaryDirectory() as name, own_ros_master():
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        rospy.Service('/stop_fleet', Trigger, lambda _: TriggerResponse(True, 'stopped'))
        map_topic = rospy.Publisher('/fleet/map', OccupancyGrid, queue_size=1)
        pem, key = certificate(Path(name))

        def rows() -> Iterator[Row]:
            for trust, pair in ((None, ()), (ssl.create_default_context(cafile=pem), (
                    f'_certificate:={pem}', f'_key:={key}'))):
                port = free_port()
                with node(port, Path(name), pair) as program:
                    yield from figures(Page(port, trust), program.pid, map_topic)
        print_table(rows())


if __name__ == '__main__':
    main()
