"""The listener accepts only the robot's connection, and survives everything that comes over it."""
from __future__ import annotations

import errno
import socket
import threading
import time
from contextlib import suppress

import pytest
from arcl_builders import STATUS, Noted, lines, wait_for

from omron_arcl import LinkPhase, Listener
from omron_arcl.listener import RIVALS


@pytest.fixture
def received() -> Noted:
    return Noted()


@pytest.fixture
def links() -> Noted:
    return Noted()


def dial(listener: Listener, source: str = '127.0.0.1') -> socket.socket:
    return socket.create_connection(('127.0.0.1', listener.port), timeout=5.0,
                                    source_address=(source, 0))


def is_closed(connection: socket.socket) -> bool:
    try:
        while connection.recv(1000):
            pass
    except ConnectionResetError:
        pass
    return True


def test_lines_come_through_without_a_login(received, links):
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received, on_link=links) as listener, \
            dial(listener) as robot:
        robot.sendall(lines(*STATUS))
        received.wait(lambda line: line.raw == STATUS[-1], 'the last line')
        assert [line.raw for line in received.all] == list(STATUS)
        assert listener.link.peer == '{}:{}'.format(*robot.getsockname())
    assert [link.phase for link in links.all] == [
        LinkPhase.DISCONNECTED, LinkPhase.CONNECTED, LinkPhase.DISCONNECTED]


def test_only_the_robots_address_may_connect(received):
    refused = Noted()
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received, on_refused=refused) as listener, \
            dial(listener) as robot, dial(listener, source='127.0.0.2') as stranger:
        assert is_closed(stranger)
        assert refused.wait(lambda address: address == '127.0.0.2', 'the refusal')
        robot.sendall(lines(b'Stopped'))
        received.wait(lambda line: line.raw == b'Stopped', 'a line of the robot')


def test_two_robots_behind_one_address_are_told_apart_from_one_that_connects_again(links):
    """Once, the lines of the two robots alternated on the same topics."""
    with Listener('127.0.0.1', 0, '127.0.0.1', on_link=links) as listener:
        robots = []
        for number in range(RIVALS + 1):
            before = len(links.all)
            robots.append(dial(listener))
            connected = links.wait(lambda link: link.connected, 'the connection', after=before)
            assert bool(connected.reason) == (number >= RIVALS), number
            robots[-1].sendall(lines(b'Stopped'))
            wait_for(lambda: listener._peer and listener._peer.is_lively(time.monotonic(), 60.0),
                     'the line comes')
        assert 'two robots' in connected.reason
        for robot in robots:
            robot.close()


def test_the_robot_may_be_given_by_name(received):
    with Listener('127.0.0.1', 0, 'localhost', on_line=received) as listener, \
            dial(listener) as robot:
        robot.sendall(lines(b'Stopped'))
        received.wait(lambda line: line.raw == b'Stopped', 'a line')


def test_a_new_connection_replaces_the_old_one(received, links):
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received, on_link=links) as listener, \
            dial(listener) as old, dial(listener) as new:
        assert is_closed(old)
        new.sendall(lines(b'Stopped'))
        received.wait(lambda line: line.raw == b'Stopped', 'a line')
        links.wait(lambda link: 'new connection' in link.reason, 'the reason')


def test_half_a_line_of_the_old_connection_does_not_run_into_the_new_one(received):
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received) as listener, \
            dial(listener) as old:
        old.sendall(b'Arrived at 1')
        with dial(listener) as new:
            assert is_closed(old)
            new.sendall(lines(b'2', b'Stopped'))
            received.wait(lambda line: line.raw == b'Stopped', 'a line')
    assert [line.raw for line in received.all] == [b'2', b'Stopped']


def test_the_listener_keeps_the_connection_alive(monkeypatch):
    monkeypatch.setattr('omron_arcl.listener.KEEP_ALIVE', 0.05)
    with Listener('127.0.0.1', 0, '127.0.0.1') as listener, dial(listener) as robot:
        heard = b''
        while len(heard) < 3:
            heard += robot.recv(100)
    assert set(heard) == {ord('\n')}


def test_a_silent_robot_is_reported_and_may_come_back(received, links):
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received, on_link=links,
                  timeout=0.2) as listener:
        with dial(listener) as robot:
            links.wait(lambda link: 'nothing was received' in link.reason, 'silence')
            assert is_closed(robot)
        with dial(listener) as robot:
            robot.sendall(lines(b'Stopped'))
            received.wait(lambda line: line.raw == b'Stopped', 'a line')


def test_a_line_beyond_all_measure_drops_the_connection(links):
    with Listener('127.0.0.1', 0, '127.0.0.1', on_link=links) as listener, \
            dial(listener) as robot:
        try:
            for _ in range(400):
                robot.sendall(b'x' * 65536)
        except OSError:
            pass  # the listener has closed the connection, as it must
        links.wait(lambda link: 'more than' in link.reason, 'the reason')


def test_a_port_of_another_program_is_named_and_taken_when_it_is_free(received, links):
    holder = socket.create_server(('127.0.0.1', 0))
    port = holder.getsockname()[1]
    with Listener('127.0.0.1', port, '127.0.0.1', on_line=received, on_link=links) as listener:
        links.wait(lambda link: f'another program has port {port}' in link.reason, 'the reason')
        holder.close()
        links.wait(lambda link: 'is free now' in link.reason, 'the news that it listens')
        with dial(listener) as robot:
            robot.sendall(lines(*STATUS))
            received.wait(lambda line: line.text.startswith('Status:'), 'a line of the robot')


def test_without_descriptors_it_waits_instead_of_spinning(monkeypatch, received, caplog):
    refused = []

    class Exhausted(socket.socket):
        def accept(self) -> tuple:
            if len(refused) < 2:
                refused.append(None)
                raise OSError(errno.EMFILE, 'Too many open files')
            return super().accept()
    monkeypatch.setattr('omron_arcl.listener.RETRY', 0.3)
    monkeypatch.setattr(socket, 'socket', Exhausted)
    begin = time.monotonic()
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received) as listener, \
            dial(listener) as robot:
        robot.sendall(lines(b'Stopped'))
        received.wait(lambda line: line.raw == b'Stopped', 'a line of the robot')
    assert time.monotonic() - begin > 0.6
    assert caplog.text.count('too many open files') == 2


@pytest.mark.parametrize('address', ['10.0..5', 'a b'])
def test_what_can_be_no_address_is_an_error(address):
    with pytest.raises(OSError, match='neither'):
        Listener(address, 0, '127.0.0.1')


def test_a_robot_that_can_be_no_host_lets_nobody_in(received):
    refused = Noted()
    with Listener('127.0.0.1', 0, '10.0..5', on_refused=refused) as listener, \
            dial(listener) as stranger:
        assert is_closed(stranger)
        refused.wait(lambda address: address == '127.0.0.1', 'the refusal')


def test_an_address_of_another_computer_is_an_error():
    with pytest.raises(OSError):
        Listener('192.0.2.1', 0, '127.0.0.1')


def test_closing_frees_the_port():
    with Listener('127.0.0.1', 0, '127.0.0.1') as listener:
        port = listener.port
    wait_for(lambda: not listener._thread.is_alive(), 'the end of the thread')
    with Listener('127.0.0.1', port, '127.0.0.1') as again:
        assert again.port == port


class NameServer:
    """A name server that answers at the time that the test chooses, with one address for all names.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.address = '127.0.0.1'
        self.answers = threading.Event()
        self.asked = 0
        self.fails = False
        monkeypatch.setattr('omron_arcl.host_addresses.resolve', self._resolve)
        monkeypatch.setattr('omron_arcl.host_addresses.AGAIN', 0.05)

    def _resolve(self, _: str) -> list:
        self.asked += 1
        self.answers.wait(10.0)
        if self.fails:
            raise OSError(errno.EAGAIN, 'temporary failure in name resolution')
        return [(0, 0, 0, '', (self.address, 0))]


@pytest.fixture
def names(monkeypatch) -> NameServer:
    return NameServer(monkeypatch)


def test_a_slow_name_server_holds_no_line_of_the_robot_up(names, received):
    names.answers.set()
    with Listener('127.0.0.1', 0, 'ld90.site', on_line=received) as listener, \
            dial(listener) as robot:
        robot.sendall(lines(b'Stopped'))
        received.wait(lambda line: line.raw == b'Stopped', 'a line')
        names.answers.clear()
        with dial(listener, source='127.0.0.2'):
            wait_for(lambda: names.asked > 1, 'a look-up for the stranger')
            robot.sendall(lines(b'Parked'))
            received.wait(lambda line: line.raw == b'Parked', 'a line meanwhile')
            names.answers.set()


def test_a_robot_waits_for_the_name_server_and_is_let_in_then(names, received):
    with Listener('127.0.0.1', 0, 'ld90.site', on_line=received) as listener, \
            dial(listener) as robot:
        robot.sendall(lines(b'Stopped'))
        wait_for(lambda: names.asked, 'a look-up')
        assert received.all == []
        names.answers.set()
        received.wait(lambda line: line.raw == b'Stopped', 'a line')


def test_after_a_failure_the_name_is_looked_up_again(names, received):
    names.fails = True
    names.answers.set()
    with Listener('127.0.0.1', 0, 'ld90.site', on_line=received) as listener:
        wait_for(lambda: names.asked >= 3, 'further look-ups, though no robot connects')
        names.fails = False
        asked = names.asked
        wait_for(lambda: names.asked > asked, 'an answer')
        with dial(listener) as robot:
            robot.sendall(lines(b'Stopped'))
            received.wait(lambda line: line.raw == b'Stopped', 'a line')


def test_a_robot_that_got_another_address_is_known_by_it(names, received):
    names.answers.set()
    with Listener('127.0.0.1', 0, 'ld90.site', on_line=received) as listener:
        wait_for(lambda: names.asked, 'the first look-up')
        names.address = '127.0.0.2'
        with dial(listener, source='127.0.0.2') as robot:
            robot.sendall(lines(b'Stopped'))
            received.wait(lambda line: line.raw == b'Stopped', 'a line')


def test_many_strangers_wait_for_nothing_while_the_name_server_is_silent(names):
    with Listener('127.0.0.1', 0, 'ld90.site') as listener:
        strangers = [dial(listener) for _ in range(6)]
        assert is_closed(strangers[0]) and is_closed(strangers[1])
        for stranger in strangers:
            stranger.close()
        names.answers.set()


@pytest.mark.parametrize('first', [b'POST / HTTP/1.1', b'GET /' + (1 << 18) * b'a' + b' HTTP/1.1',
                                   b'Status: / HTTP/1.1'], ids=len)
def test_no_line_of_a_web_page_is_taken_for_the_robots(received, links, first):
    """A web page can make a browser on the robot's computer (in a simulation) send any text."""
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received, on_link=links) as listener, \
            dial(listener) as page:
        links.wait(lambda link: link.phase is LinkPhase.CONNECTED, 'the connection')
        with suppress(ConnectionError):
            page.sendall(first + b'\r\nHost: 127.0.0.1\r\nOrigin: null\r\n\r\n' + lines(*STATUS))
        assert is_closed(page)
        links.wait(lambda link: link.phase is LinkPhase.DISCONNECTED and link.reason !=
                   links.all[0].reason, 'the end of the connection')
    assert received.all == []
