"""TCP sockets for the sans-I/O server: one thread, one selector, one simulated clock.

The loop sleeps until a socket is ready or the clock's next callback is due; wall time times the
speed factor is simulated time.
"""
from __future__ import annotations

import errno
import selectors
import socket
import time
from typing import Callable, Dict, List, Optional, Tuple

from omron_ld90_sim.clock import Clock
from omron_ld90_sim.server import ArclServer, OutgoingLists, Session

RECONNECT = 1.0         # s between two attempts of the outgoing connection
MAX_OUTPUT = 8_000_000  # bytes a client may leave unread before it is dropped


class PortTaken(Exception):
    """The ARCL port cannot be listened on."""


class Loop:
    """Runs sockets and the clock."""

    def __init__(self, clock: Clock, speed: float) -> None:
        self.clock, self.speed = clock, speed
        self.selector = selectors.DefaultSelector()
        self._wake_read, self._wake_write = socket.socketpair()
        self._wake_read.setblocking(False)
        self.selector.register(self._wake_read, selectors.EVENT_READ, self._woken)
        self._calls: List[Callable[[], None]] = []
        self._running = False
        self._start = time.monotonic()
        self.after_step: List[Callable[[], None]] = []

    def _simulated_now(self) -> float:
        return (time.monotonic() - self._start) * self.speed

    def run(self) -> None:
        """Runs until `stop`."""
        self._start = time.monotonic() - self.clock.now / self.speed
        self._running = True
        while self._running:
            due = self.clock.next_time
            timeout = None
            if due is not None:
                timeout = max((due - self._simulated_now()) / self.speed, 0.0)
            ready = self.selector.select(timeout)
            self.clock.advance(self._simulated_now())
            for key, mask in ready:
                key.data(mask)
            for callback in self.after_step:
                callback()

    def call(self, function: Callable[[], None]) -> None:
        """Has the loop's thread call `function` soon; safe from any thread."""
        self._calls.append(function)
        self._wake_write.send(b'.')

    def _woken(self, mask: int) -> None:
        self._wake_read.recv(4096)
        while self._calls:
            self._calls.pop(0)()

    def stop(self) -> None:
        """Ends `run`; safe from any thread and from a signal handler."""
        self._running = False
        self._wake_write.send(b'.')

    def close(self) -> None:
        """Frees the loop's own sockets."""
        self.selector.close()
        self._wake_read.close()
        self._wake_write.close()


class Connection:
    """One TCP connection and its session."""

    def __init__(self, loop: Loop, sock: socket.socket, session: Session,
                 gone: Callable[[Connection], None]) -> None:
        self.loop, self.sock, self.session, self._gone = loop, sock, session, gone
        self._mask = selectors.EVENT_READ
        loop.selector.register(sock, self._mask, self._ready)

    def _ready(self, mask: int) -> None:
        if mask & selectors.EVENT_READ:
            try:
                data = self.sock.recv(65536)
            except BlockingIOError:
                return
            except OSError:
                data = b''
            if not data:
                self.close()
                return
            self.session.receive(data)
        self.flush()

    def flush(self) -> None:
        """Sends what can be sent now and waits for room for the rest."""
        if self.sock.fileno() < 0:
            return
        output = self.session.output
        try:
            while output:
                del output[:self.sock.send(output)]
        except BlockingIOError:
            pass
        except OSError:
            self.close()
            return
        if len(output) > MAX_OUTPUT or (self.session.closed and not output):
            self.close()
            return
        mask = selectors.EVENT_READ | (selectors.EVENT_WRITE if output else 0)
        if mask != self._mask:
            self._mask = mask
            self.loop.selector.modify(self.sock, mask, self._ready)

    def close(self) -> None:
        """Ends the connection."""
        if self.sock.fileno() >= 0:
            self.loop.selector.unregister(self.sock)
            self.sock.close()
            self.session.server.forget(self.session)
            self._gone(self)


class TcpServer:
    """One robot's listening port and outgoing connection."""

    def __init__(self, loop: Loop, server: ArclServer, port: int, host: str,
                 outgoing: Optional[Tuple[str, int]], lists: Dict[int, tuple]) -> None:
        self.loop, self.server = loop, server
        self._outgoing, self._lists = outgoing, lists
        self._connections: List[Connection] = []
        self._listener = self._listen(host, port)
        self.port: int = self._listener.getsockname()[1]
        loop.selector.register(self._listener, selectors.EVENT_READ, self._accept)
        loop.after_step.append(self.flush)
        if outgoing is not None:
            self._dial()

    def _listen(self, host: str, port: int) -> socket.socket:
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, port))
            listener.listen(64)
        except OSError as error:
            listener.close()
            if error.errno == errno.EADDRINUSE:
                raise PortTaken(f'port {port} on {host} is taken by another program: end that one '
                                f'or choose another port with --port') from error
            raise PortTaken(f'cannot listen on port {port} of {host}: {error.strerror}; choose '
                            f'another port with --port') from error
        listener.setblocking(False)
        return listener

    def _accept(self, mask: int) -> None:
        try:
            sock, _ = self._listener.accept()
        except OSError:
            return
        self._add(sock, self.server.connect())

    def _add(self, sock: socket.socket, session: Session) -> Connection:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection = Connection(self.loop, sock, session, self._forget)
        self._connections.append(connection)
        connection.flush()
        return connection

    def _forget(self, connection: Connection) -> None:
        self._connections.remove(connection)
        if connection.session.outgoing:
            self.loop.clock.after(RECONNECT, self._dial)

    def _dial(self) -> None:
        """Tries the outgoing connection; again in a while when nobody listens."""
        sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        sock.setblocking(False)
        error = sock.connect_ex(self._outgoing)
        if error not in (0, errno.EINPROGRESS):
            sock.close()
            self.loop.clock.after(RECONNECT, self._dial)
            return
        self.loop.selector.register(sock, selectors.EVENT_WRITE, lambda mask: self._dialled(sock))

    def _dialled(self, sock: socket.socket) -> None:
        self.loop.selector.unregister(sock)
        if sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR):
            sock.close()
            self.loop.clock.after(RECONNECT, self._dial)
            return
        session = self.server.connect_outgoing()
        OutgoingLists(self.server, session, self._lists)
        self._add(sock, session)

    def flush(self) -> None:
        """Sends what the sessions have queued."""
        for connection in list(self._connections):
            if connection.session.output or connection.session.closed:
                connection.flush()

    def close(self) -> None:
        """Says good-bye to everybody and closes."""
        self.server.broadcast('Shutting down server')
        self.flush()
        self._outgoing = None
        for connection in list(self._connections):
            connection.close()
        self.loop.selector.unregister(self._listener)
        self._listener.close()
