"""The addresses of a host are tried one by one; a peer must be alive and send new data."""
from __future__ import annotations

import contextlib
import errno
import socket
import time
from typing import Iterator, List, Tuple

import pytest
from arcl_builders import lines

from omron_arcl import Backoff, connection
from omron_arcl.connection import ArclConnection, LivePeer, is_host, reason_of, resolve
from omron_arcl.errors import ConnectionFailed, ConnectionLost, PeerSilent, WrongPassword
from omron_arcl.session import Received, Session


def never() -> bool:
    return False


# --- connecting -----------------------------------------------------------------------------------

@pytest.mark.parametrize('host', ['10.0..5', 'a' * 64 + '.b', 'ro\x00bot', 'a b'])
def test_a_text_that_can_be_no_host_has_no_address_and_the_reason_names_it(host):
    with pytest.raises(OSError) as failure:
        ArclConnection.open(host, 7171, 1.0, never)
    assert 'neither an address nor a name' in reason_of(failure.value)


@pytest.mark.parametrize(('host', 'possible'), [
    ('10.0.0.5', True), ('robot-7.site', True), ('::1', True), ('k\xfcche', True),
    ('10.0..5', False), ('', False), ('a b', False), ('a\nb', False), ('a' * 64, False)])
def test_what_can_be_a_host(host, possible):
    assert is_host(host) is possible


def test_the_next_address_is_tried_where_one_cannot_be_reached(monkeypatch):
    with socket.create_server(('127.0.0.1', 0)) as server:
        port = server.getsockname()[1]
        good = (socket.AF_INET, socket.SOCK_STREAM, 0, '', ('127.0.0.1', port))
        bad = (socket.AF_INET, socket.SOCK_STREAM, 0, '', ('127.0.0.1', 1))
        monkeypatch.setattr(connection, 'resolve', lambda host, port: [bad, good])
        with ArclConnection.open('robot', port, 1.0, never) as opened:
            assert opened.socket.getpeername() == ('127.0.0.1', port)


def test_an_address_that_fails_at_once_is_not_connected(monkeypatch):
    """Without a route to a network, `connect_ex` itself reports the error, and no event follows."""
    class Unreachable(socket.socket):
        def connect_ex(self, address: object) -> int:
            return errno.ENETUNREACH

    monkeypatch.setattr(connection.socket, 'socket', Unreachable)
    with pytest.raises(OSError) as failure:
        ArclConnection.open('127.0.0.1', 7171, 1.0, never)
    assert failure.value.errno == errno.ENETUNREACH
    assert reason_of(failure.value) == 'network is unreachable'


@pytest.mark.parametrize('seconds, gives_up', [(0.2, False), (60.0, True)])
def test_an_address_that_does_not_answer_is_given_up_in_time_and_at_the_end(seconds, gives_up):
    with socket.socket() as deaf, contextlib.ExitStack() as waiting:
        deaf.bind(('127.0.0.1', 0))
        deaf.listen(0)
        for _ in range(2):  # these fill the queue: the kernel drops further connections
            client = waiting.enter_context(socket.socket())
            client.setblocking(False)
            client.connect_ex(deaf.getsockname())
        with pytest.raises(OSError) as failure:
            ArclConnection.open('127.0.0.1', deaf.getsockname()[1], seconds, lambda: gives_up)
    assert failure.value.errno == errno.ETIMEDOUT


def test_without_descriptors_it_fails_and_leaves_none(monkeypatch):
    def none_left(*_: object) -> socket.socket:
        raise OSError(errno.EMFILE, 'too many open files')
    monkeypatch.setattr(connection.socket, 'socket', none_left)
    with pytest.raises(OSError, match='too many'):
        ArclConnection.open('127.0.0.1', 7171, 1.0, never)


def test_a_host_may_have_several_addresses():
    assert all(entry[4][0] in ('127.0.0.1', '::1') for entry in resolve('localhost', 7171))


# --- peers ----------------------------------------------------------------------------------------

@pytest.fixture
def pair() -> Iterator[Tuple[LivePeer, socket.socket]]:
    ours, robot = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    peer = LivePeer.__new__(LivePeer)
    bare = ArclConnection.__new__(ArclConnection)  # not __init__: a socket pair has no TCP options
    bare.socket, bare.unsent = ours, b''
    ours.setblocking(False)
    LivePeer.__init__(peer, bare, Session(None), timeout=2.0)
    with ours, robot:
        yield peer, robot


def heard(peer: LivePeer, now: float, waited: float = 0.1) -> List[Received]:
    return [event for event in peer.receive(now, waited) if isinstance(event, Received)]


def test_a_byte_now_and_then_is_no_sign_of_life(pair):
    peer, robot = pair
    now = time.monotonic()
    with pytest.raises(PeerSilent):
        for tenth in range(100):
            robot.sendall(b'x')
            assert heard(peer, now + tenth / 10.0) == []
    assert tenth >= 20


def test_a_line_now_and_then_is_a_sign_of_life(pair):
    peer, robot = pair
    now = time.monotonic()
    for second in range(100):
        robot.sendall(lines(b'Stopped'))
        assert len(heard(peer, now + second)) == 1


def test_a_robot_that_takes_nothing_is_gone_though_it_talks(pair):
    peer, robot = pair
    now = time.monotonic()
    peer.connection.send(b'x' * 10_000_000)
    assert peer.connection.unsent
    with pytest.raises(ConnectionLost, match='not accepted any data'):
        for tenth in range(100):
            robot.sendall(lines(b'Stopped'))
            heard(peer, now + tenth / 10.0)


def test_what_waited_while_we_stood_still_is_late_and_what_comes_afterwards_is_not(pair):
    peer, robot = pair
    now = time.monotonic()
    robot.sendall(lines(b'Location: 1 0 0'))
    assert [line.late for line in heard(peer, now)] == [False]
    robot.sendall(lines(*[b'Location: 2 0 0'] * 3))
    assert [line.late for line in heard(peer, now + 10.0)] == [True] * 3
    robot.sendall(lines(b'Location: 3 0 0'))  # this line waited in the other side's buffers
    assert [line.late for line in heard(peer, now + 10.001, waited=0.001)] == [True]
    robot.sendall(lines(b'Location: 4 0 0'))
    assert [line.late for line in heard(peer, now + 10.2, waited=0.1)] == [False]


def test_a_burst_after_a_stall_of_the_network_is_late_and_what_comes_afterwards_is_not(pair):
    """Once, locations were published as new although the robot had driven on by up to 3.3 m."""
    peer, robot = pair
    now = time.monotonic()
    for tenth in range(20):
        robot.sendall(lines(b'Location: 1 0 0'))
        assert [line.late for line in heard(peer, now + tenth / 10)] == [False]
    for tenth in range(20, 38):
        assert heard(peer, now + tenth / 10) == []
    for piece in range(3):
        robot.sendall(lines(*[b'Location: 2 0 0'] * 10))
        assert [line.late for line in heard(
            peer, now + 3.8 + piece / 500, waited=0.1 if piece == 0 else 0.002)] == [True] * 10
    robot.sendall(lines(b'Location: 3 0 0'))
    assert [line.late for line in heard(peer, now + 3.9)] == [False]


@pytest.mark.parametrize('period', [0.1, 0.5, 1.9])
def test_a_stream_of_any_period_is_never_late(pair, period):
    peer, robot = pair
    now = time.monotonic()
    for count in range(1, 60):
        assert heard(peer, now + (count - 0.5) * period) == []
        robot.sendall(lines(b'Location: 1 0 0'))
        assert [line.late for line in heard(peer, now + count * period)] == [False]


def test_what_is_read_after_a_standstill_between_the_wait_and_the_read_is_late(pair, monkeypatch):
    peer, robot = pair
    now = time.monotonic()
    robot.sendall(lines(b'Location: 1 0 0'))
    monkeypatch.setattr(connection.time, 'monotonic', lambda: now + 3.0)  # while it reads
    assert [line.late for line in heard(peer, now)] == [True]
    robot.sendall(lines(b'Location: 2 0 0'))
    assert [line.late for line in heard(peer, now + 3.1)] == [False]


def test_a_stream_that_never_pauses_is_new_again_soon_after_we_stood_still(pair):
    peer, robot = pair
    now = time.monotonic() + 10.0
    late = []
    for hundredth in range(100):
        robot.sendall(lines(b'Location: 1 0 0'))
        late += [line.late for line in heard(peer, now + hundredth / 100, waited=0.009)]
    assert late[0]
    assert late == sorted(late, reverse=True)
    assert 40 < sum(late) < 60


# -- the waiting time before the next attempt to connect -------------------------------------------

def test_a_wrong_password_waits_longer_than_a_lost_connection():
    backoff = Backoff(jitter=0.0)
    assert backoff.after(WrongPassword('x')) == 30.0
    assert [backoff.after(ConnectionFailed('x')) for _ in range(7)] \
        == [0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0]
    backoff.reset()
    assert backoff.after(ConnectionFailed('x')) == 0.5


def test_backoff_is_spread_within_its_share_and_never_beyond_its_cap():
    waits = [Backoff(first=5.0, cap=5.5, jitter=0.2).after(ConnectionFailed('x'))
             for _ in range(200)]
    assert all(4.0 <= wait <= 5.5 for wait in waits)
    assert len(set(waits)) > 100
