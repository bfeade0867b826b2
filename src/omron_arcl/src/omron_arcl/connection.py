"""A TCP connection that never blocks, and the lines that come over it."""
from __future__ import annotations

import contextlib
import errno
import os
import selectors
import socket
import struct
import time
from typing import Any, Callable, Iterator, List, Optional, Tuple, Union

from omron_arcl.errors import ConnectionLost, PeerSilent
from omron_arcl.session import Closed, LoggedIn, Received, Session

_CHUNK = 1 << 16
_CONNECT_TICK = 0.1  # s
_STANDSTILL = 1.0  # s; after a longer time between two reads, the received data may be old
_GAPS = 4.0  # after a pause of the peer so many times the usual one, its data may be old
# Data counts as new again if the thread has waited for it longer than _DRAINED. If the data has
# been old for longer than _FLUSHED, a wait longer than _WAITED suffices.
_DRAINED = 0.03  # s
_WAITED, _FLUSHED = 0.001, 0.5  # s
_IN_PROGRESS = (0, errno.EINPROGRESS, errno.EWOULDBLOCK)


class ArclConnection:
    """A connected socket with a buffer for data that could not be sent yet."""

    def __init__(self, connected: socket.socket) -> None:
        self.socket = connected
        self.unsent = b''
        connected.setblocking(False)
        _make_lively(connected)

    @classmethod
    def open(cls, host: str, port: int, timeout: float,
             give_up: Callable[[], bool]) -> ArclConnection:
        """Connects to each address of the host in turn, within `timeout` s for each.

        Raises OSError. Gives up within `_CONNECT_TICK` when `give_up` returns True.
        """
        failure = OSError(errno.EADDRNOTAVAIL, f'{host} has no address')
        for family, kind, protocol, _, address in resolve(host, port):
            try:
                attempt = socket.socket(family, kind, protocol)
            except OSError as error:
                failure = error
                continue
            try:
                attempt.setblocking(False)
                _check(attempt.connect_ex(address), *_IN_PROGRESS)
                _await_connected(attempt, timeout, give_up)
                return cls(attempt)
            except OSError as error:
                attempt.close()
                failure = error
        raise failure

    def __enter__(self) -> ArclConnection:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the socket."""
        self.socket.close()

    def reset_when_closed(self) -> None:
        """Makes the kernel drop undelivered data when the socket closes."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))

    def receive(self) -> Optional[bytes]:
        """Returns the received bytes. None: there are none yet; b'': the peer has closed.

        Raises OSError.
        """
        try:
            return self.socket.recv(_CHUNK)
        except BlockingIOError:
            return None

    def send(self, data: bytes) -> None:
        """Sends as much as possible now, and keeps the rest. Raises OSError."""
        self.unsent += data
        with contextlib.suppress(BlockingIOError):
            while self.unsent:
                self.unsent = self.unsent[self.socket.send(self.unsent):]


class LivePeer:
    """A connection with its session: the robot's lines, and whether the robot is alive.

    timeout: s; the robot counts as gone if it sends no complete line, or accepts no data, for a
    longer time. Single bytes without a line end are no sign of life.

    Its attributes are the times that show whether the robot is alive.
    """

    def __init__(self, connection: ArclConnection, session: Session, timeout: float) -> None:
        self.connection = connection
        self.session = session
        self._timeout = timeout
        self._heard = self._looked = self._sent = time.monotonic()
        self._lines = 0
        self._late = False
        self._resumed = 0.0
        self._data_at = self._heard
        self._pause: Optional[float] = None  # s, usual time between two pieces of data

    def receive(self, now: float, waited: float) -> Iterator[Union[LoggedIn, Received]]:
        """Yields the events in the received data. The caller has waited `waited` s for this data.

        Raises LinkError or OSError when the connection is over.
        """
        data = self.connection.receive()
        read = max(now, time.monotonic())  # the process may have been suspended in between
        if read - self._looked > _STANDSTILL or data and self._follows_a_gap(read, waited):
            self._late, self._resumed = True, read
        elif waited > _DRAINED or (waited > _WAITED and read - self._resumed > _FLUSHED):
            self._late = False
        self._looked = read
        events = () if data is None else (
            self.session.read(data) if data else self.session.receive_eof())
        for event in events:
            if isinstance(event, Closed):
                raise event.cause
            yield event._replace(late=True) if self._late and isinstance(event, Received) else event
        self._check_alive(now)

    def _check_alive(self, now: float) -> None:
        """Raises ConnectionLost or PeerSilent."""
        if self._lines != self.session.lines_read:
            self._lines, self._heard = self.session.lines_read, now
        elif now - self._heard > self._timeout:
            raise PeerSilent(now - self._heard, self.session.words)
        if not self.connection.unsent:
            self._sent = now
        elif now - self._sent > self._timeout:
            raise ConnectionLost('the robot has not accepted any data for '
                                 f'{now - self._sent:.1f} s')

    def is_lively(self, now: float, seconds: float) -> bool:
        """Returns whether a line has come within the last `seconds`."""
        return self._lines > 0 and now - self._heard <= seconds

    def _follows_a_gap(self, read: float, waited: float) -> bool:
        """Returns whether a stall of the network has delayed the peer's data."""
        pause, self._data_at = read - self._data_at, read
        if waited <= _DRAINED:
            return False
        usual = self._pause
        if usual is not None and pause > max(_STANDSTILL, _GAPS * usual):
            return True
        self._pause = pause if usual is None else usual + (pause - usual) / 8.0
        return False


def resolve(host: str, port: Optional[int] = None) -> List[Tuple[Any, ...]]:
    """Returns the addresses of a host in the form of `getaddrinfo`; raises OSError.

    Also raises OSError for a text that cannot be a host name, such as `10.0..5`.
    """
    if not is_host(host):
        raise OSError(errno.EINVAL, f'"{host}" is neither an address nor a name')
    return socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)


def is_host(text: str) -> bool:
    """Returns whether a text can be a host's name or address."""
    try:
        return bool(text.encode('idna')) and text.isprintable() and ' ' not in text
    except UnicodeError:
        return False


def reason_of(error: OSError) -> str:
    """Returns the text of an OSError, without its number."""
    text = error.strerror or str(error)
    return text if '"' in text else text.lower()


def _check(code: int, *good: int) -> None:
    if code not in good:
        raise OSError(code, os.strerror(code))


def _await_connected(attempt: socket.socket, timeout: float, give_up: Callable[[], bool]) -> None:
    deadline = time.monotonic() + timeout
    with selectors.DefaultSelector() as selector:
        selector.register(attempt, selectors.EVENT_WRITE)
        while not selector.select(_CONNECT_TICK):
            if give_up() or time.monotonic() > deadline:
                raise OSError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT))
    _check(attempt.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR), 0)


def _make_lively(connected: socket.socket) -> None:
    """Turns off the send delay. Makes the kernel notice a vanished peer even without traffic."""
    connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in (('TCP_KEEPIDLE', 2), ('TCP_KEEPINTVL', 1), ('TCP_KEEPCNT', 3),
                          ('TCP_USER_TIMEOUT', 5000)):
        if hasattr(socket, option):
            connected.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
