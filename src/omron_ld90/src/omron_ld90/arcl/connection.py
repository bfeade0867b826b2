"""A TCP connection that never blocks: what both transports stand on."""
from __future__ import annotations

import contextlib
import errno
import os
import selectors
import socket
import time
from typing import Callable, Optional

_CHUNK = 1 << 16
_TICK = 0.1  # s


class Connection:
    """A connected socket with a buffer of what could not be sent yet."""

    def __init__(self, connected: socket.socket) -> None:
        self.socket = connected
        self.unsent = b''
        connected.setblocking(False)
        _make_lively(connected)

    @classmethod
    def open(cls, host: str, port: int, timeout: float, give_up: Callable[[], bool]) -> Connection:
        """Connects; raises OSError. Breaks off within a moment when `give_up` says so."""
        failure = OSError(errno.EADDRNOTAVAIL, f'{host} has no address')
        for family, kind, protocol, _, address in socket.getaddrinfo(
                host, port, type=socket.SOCK_STREAM):
            attempt = socket.socket(family, kind, protocol)
            try:
                attempt.setblocking(False)
                attempt.connect_ex(address)
                _await_connected(attempt, timeout, give_up)
                return cls(attempt)
            except OSError as error:
                attempt.close()
                failure = error
        raise failure

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the socket."""
        self.socket.close()

    def receive(self) -> Optional[bytes]:
        """What has come: None for nothing yet, b'' for the end. Raises OSError when broken."""
        try:
            return self.socket.recv(_CHUNK)
        except BlockingIOError:
            return None

    def send(self, data: bytes) -> None:
        """Sends as much as goes now, keeps the rest. Raises OSError when broken."""
        self.unsent += data
        with contextlib.suppress(BlockingIOError):
            while self.unsent:
                self.unsent = self.unsent[self.socket.send(self.unsent):]


def reason_of(error: OSError) -> str:
    """What an OSError says, without its number."""
    return (error.strerror or str(error)).lower()


def _await_connected(attempt: socket.socket, timeout: float, give_up: Callable[[], bool]) -> None:
    deadline = time.monotonic() + timeout
    with selectors.DefaultSelector() as selector:
        selector.register(attempt, selectors.EVENT_WRITE)
        while not selector.select(_TICK):
            if give_up() or time.monotonic() > deadline:
                raise OSError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT))
    code = attempt.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
    if code:
        raise OSError(code, os.strerror(code))


def _make_lively(connected: socket.socket) -> None:
    """Sends at once; the kernel notices a peer that vanished even while we say nothing."""
    connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in (('TCP_KEEPIDLE', 2), ('TCP_KEEPINTVL', 1), ('TCP_KEEPCNT', 3),
                          ('TCP_USER_TIMEOUT', 5000)):
        if hasattr(socket, option):
            connected.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)


class Waker:
    """Ends a thread's wait in a selector from another thread."""

    def __init__(self) -> None:
        self.reader, self._writer = socket.socketpair()
        self.reader.setblocking(False)
        self._writer.setblocking(False)

    def wake(self) -> None:
        """Ends the wait; harmless after `close`."""
        with contextlib.suppress(OSError):
            self._writer.send(b'\0')

    def drain(self) -> None:
        """Takes the wakes that have been."""
        with contextlib.suppress(OSError):
            self.reader.recv(_CHUNK)

    def close(self) -> None:
        """Frees the descriptors."""
        self.reader.close()
        self._writer.close()
