"""A TCP connection that never blocks, and the thread that serves one: for both transports."""
from __future__ import annotations

import contextlib
import errno
import logging
import os
import selectors
import socket
import threading
import time
from typing import Any, Callable, Optional, TypeVar

from omron_arcl.errors import ConnectionLost, LinkError

TICK = 0.2  # s between looks at the clock
_CHUNK = 1 << 16
_CONNECT_TICK = 0.1  # s
_log = logging.getLogger(__name__)
_Own = TypeVar('_Own', bound='Transport')


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
        while not selector.select(_CONNECT_TICK):
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


class Transport:
    """A thread that serves connections from `start` until `close`; also a context manager.

    A kind of it is its method `_run`, which ends soon after `_closing` is set: `_waker` wakes it.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._closing = threading.Event()
        self._waker = Waker()
        self._thread = threading.Thread(target=self._run_and_free, name=name, daemon=True)

    def start(self: _Own) -> _Own:
        """Begins to connect, or to listen."""
        self._thread.start()
        return self

    def __enter__(self: _Own) -> _Own:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection; what is under way ends as lost. Takes well under a second."""
        self._closing.set()
        self._waker.wake()
        if threading.current_thread() is not self._thread:
            self._thread.join(1.0)

    def _run_and_free(self) -> None:
        self._run()
        self._waker.close()

    def _run(self) -> None:
        raise NotImplementedError

    def _cause(self, error: Exception) -> LinkError:
        """Why a connection ended on `error`. Our own mistakes are logged, and end it too."""
        if isinstance(error, LinkError):
            return error
        if isinstance(error, OSError):
            return ConnectionLost(f'the connection broke: {reason_of(error)}')
        _log.error('The %s failed.', self._name, exc_info=error)
        return ConnectionLost(f'an error of our own: {error!r}')

    def _call(self, callback: Optional[Callable[..., None]], *arguments: Any) -> None:
        """A caller's mistake in a callback must not end the connection: it is logged."""
        if callback:
            try:
                callback(*arguments)
            except Exception:
                _log.exception('A callback of the %s failed.', self._name)
