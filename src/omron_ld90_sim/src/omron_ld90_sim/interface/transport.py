"""TCP sockets for the server without I/O: a robot's port, its clients, its outgoing connection."""
from __future__ import annotations

import errno
import selectors
import socket
import struct
from typing import Callable, List, Optional, Protocol, Tuple

from omron_ld90_sim.interface.configuration import RobotConfiguration
from omron_ld90_sim.interface.configuration_table import OUTGOING
from omron_ld90_sim.interface.loop import Loop

RECONNECT = 1.0         # s between two attempts of the outgoing connection
_RESET = struct.pack('ii', 1, 0)    # SO_LINGER with time 0: close() sends RST
MAX_OUTPUT = 8_000_000  # bytes that a client may leave unread before it is dropped


class PortTaken(Exception):
    """It is impossible to listen on the ARCL port."""


class ConnectedSession(Protocol):
    """What a connection requires of its session."""

    output: bytearray
    outgoing: bool
    aborted: bool

    @property
    def closed(self) -> bool:
        """Whether the session has ended."""

    @property
    def finished(self) -> bool:
        """Whether it is closed and everything has been sent."""

    def receive(self, data: bytes) -> None:
        """Receives bytes from the other side."""

    def close(self) -> None:
        """Ends the session after the other side has ended the connection."""


class Server(Protocol):
    """The interface of a server, as a TCP port requires it.

    The server is a simulated robot, a simulated Fleet Manager, or the playback of a session log.
    """

    configuration: RobotConfiguration
    online: bool
    accepting: bool
    outgoing_wanted: bool

    def connect(self) -> ConnectedSession:
        """Begins the session of a new client."""

    def connect_outgoing(self) -> ConnectedSession:
        """Begins the session of the outgoing connection."""

    def shut_down(self) -> None:
        """Sends a farewell to all clients."""


class ClientConnection:
    """One TCP connection and its session."""

    def __init__(self, loop: Loop, sock: socket.socket, session: ConnectedSession,
                 gone: Callable[[ClientConnection], None]) -> None:
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
        """Sends as much as possible now; the rest is sent when there is room."""
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
        if self.session.aborted:
            self.sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
        if len(output) > MAX_OUTPUT or self.session.finished:
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
            self.session.close()
            self._gone(self)


class TcpServer:
    """One robot's port and outgoing connection; the server decides which of them are open."""

    def __init__(self, loop: Loop, server: Server, host: str, port: int) -> None:
        self.loop, self.server = loop, server
        self._host = host
        self._connections: List[ClientConnection] = []
        self._listener: Optional[socket.socket] = self._listen(port)
        self.port: int = self._listener.getsockname()[1]
        self._dialling: Optional[socket.socket] = None
        self._next_dial = self._next_listen = 0.0
        self._closing = False
        loop.after_step.append(self._maintain)
        loop.clock.after(0.0, self._maintain)

    # -- the port ------------------------------------------------------------------------------

    def _listen(self, port: int) -> socket.socket:
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((self._host, port))
            listener.listen(64)
        except OSError as error:
            listener.close()
            reason = ('is taken by another program' if error.errno == errno.EADDRINUSE
                      else f'cannot be listened on ({error.strerror})')
            raise PortTaken(f'port {port} of {self._host} {reason}: free the port or choose '
                            f'another port with --port') from error
        listener.setblocking(False)
        self.loop.selector.register(listener, selectors.EVENT_READ, self._accept)
        return listener

    def _close_listener(self) -> None:
        if self._listener is not None:
            self.loop.selector.unregister(self._listener)
            self._listener.close()
            self._listener = None

    def _accept(self, mask: int) -> None:
        if self._listener is None:
            return
        try:
            sock, _ = self._listener.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):     # no descriptor is free
                self._close_listener()
                self._listen_later()
            return
        self._add(sock, self.server.connect())

    def _listen_later(self) -> None:
        """Keeps the port closed for RECONNECT seconds."""
        self._next_listen = self.loop.clock.now + RECONNECT
        self.loop.clock.at(self._next_listen, self._maintain)

    def _add(self, sock: socket.socket, session: ConnectedSession) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection = ClientConnection(self.loop, sock, session, self._connections.remove)
        self._connections.append(connection)
        connection.flush()

    # -- the outgoing connection -----------------------------------------------------------------

    def _target(self) -> Optional[Tuple[str, int]]:
        settings = self.server.configuration
        host = settings.text(OUTGOING, 'OutgoingHostname')
        port = int(settings.number(OUTGOING, 'OutgoingPort'))
        wanted = self.server.online and self.server.outgoing_wanted and not self._closing
        return (host, port) if host and port and wanted else None

    def _dial(self) -> None:
        """Tries to open the outgoing connection. If no program listens, another try follows later.
        """
        target, now = self._target(), self.loop.clock.now
        standing = any(c.session.outgoing for c in self._connections)
        if target is None or standing or self._dialling is not None or now < self._next_dial:
            return
        self._next_dial = now + RECONNECT
        self.loop.clock.at(self._next_dial, self._maintain)
        try:
            sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        except OSError:         # no free descriptor
            return
        sock.setblocking(False)
        try:
            error = sock.connect_ex(target)
        except OSError:         # a host name that does not resolve
            error = errno.EHOSTUNREACH
        if error not in (0, errno.EINPROGRESS):
            sock.close()
            return
        self._dialling = sock
        self.loop.selector.register(sock, selectors.EVENT_WRITE, self._dialled)

    def _dialled(self, mask: int) -> None:
        sock, self._dialling = self._dialling, None
        if sock is None:
            return
        self.loop.selector.unregister(sock)
        if (sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) or self._target() is None
                or sock.getsockname() == sock.getpeername()):   # TCP can connect to itself
            sock.close()
            return
        self._add(sock, self.server.connect_outgoing())

    # -- upkeep --------------------------------------------------------------------------------

    def _maintain(self) -> None:
        """Opens or closes port and outgoing connection as the server demands; sends bytes."""
        open_port = self.server.online and self.server.accepting and not self._closing
        if open_port and self._listener is None and self.loop.clock.now >= self._next_listen:
            try:
                self._listener = self._listen(self.port)
            except (PortTaken, OSError):    # another program took the port; or no free descriptor
                self._listen_later()
        elif not open_port:
            self._close_listener()
        for connection in list(self._connections):
            if connection.session.output or connection.session.closed:
                connection.flush()
        self._dial()

    def close(self) -> None:
        """Sends a farewell to all clients and closes."""
        self._closing = True
        self.server.shut_down()
        self._maintain()
        if self._dialling is not None:
            self.loop.selector.unregister(self._dialling)
            self._dialling.close()
        for connection in list(self._connections):
            connection.close()
