"""Accepts connections, and limits them until their persons are known."""
from __future__ import annotations

import asyncio
import contextlib
import logging
import re
import socket
import ssl
import time
from typing import Any, Callable, Dict, Optional, Set, cast

from fleet_page.core.admissions import Admissions, place_of

HEAD_WITHIN = 5.0       # s for the head of a request, for the TLS handshake, and for the body
IDLE = 60.0             # s for the next request of a connection
STRANGER_WITHIN = 20.0  # s for the answer to a request without a login
BACKLOG = 4096          # connections that wait in the kernel until they are accepted
LONGEST_HEAD = 16384    # bytes
_AT_ONCE = 256          # new connections, at most, that are accepted without serving open ones
_ADMITTED_AT_ONCE = 16  # the largest number of these connections that are let in
_PAUSE = 0.2            # s without accepting, after the operating system had no connection left
_TLS_HANDSHAKE = b'\x16'  # first byte of a record: its type; bytes 4 and 5: its length
_ENCODING = re.compile(rb'\n[ \t]*content-encoding[ \t]*:', re.IGNORECASE)
_KEPT = 64             # last bytes that are searched again: a header's name may begin in them
_REFUSED_ENCODING = (
    b'HTTP/1.1 415 Unsupported Media Type\r\nContent-Type: text/plain\r\nContent-Length: 37\r\n'
    b'Connection: close\r\n\r\nCompressed requests are not accepted.')
_LOG = logging.getLogger(__name__)


class Connection(asyncio.Protocol):
    """One connection. It passes bytes to aiohttp's protocol, and ends if bytes do not come in time.

    Until the head of a request has come (with TLS: the first record), a connection is only a
    socket, so half a request costs little. Each later head and body must come in time, too.

    A request with the header `Content-Encoding` ends the connection before aiohttp expands the
    content. Old versions of aiohttp cannot be told not to expand it. A JSON body cannot contain
    this header, because a line end in a string is escaped.
    """

    def __init__(self, listener: DoorListener, sock: socket.socket, place: str) -> None:
        self._listener, self._sock, self.place = listener, sock, place
        self.inner: Any = None
        self._transport: Optional[asyncio.Transport] = None
        self._timer: Optional[asyncio.TimerHandle] = None
        self._begun: Optional[asyncio.Future[None]] = None
        self._is_idle = True  # no byte of the next request has come
        self._tail = b''
        self._work: Optional[asyncio.Future[Any]] = None

    # -- a bare socket -----------------------------------------------------------------------------

    def wait_for_head(self) -> None:
        """Begins to serve as soon as the head has come. Until then the kernel keeps the bytes."""
        self._end_after(HEAD_WITHIN)
        self._on_bytes(0)

    def _on_bytes(self, seen: int) -> None:
        """Notes that bytes have come; `seen`: the number of bytes at the last call."""
        data = _peek(self._sock)
        if data is None:
            asyncio.get_event_loop().add_reader(self._sock, self._on_bytes, 0)
        elif self._listener.is_whole(data) and not self._listener.is_foreign(data):
            self._stop_timer()
            self._stop_reading()
            self._begun = asyncio.ensure_future(self._begin())
        elif len(data) <= seen or len(data) >= LONGEST_HEAD or self._listener.is_foreign(data):
            self.end()  # the other side has ended it, sends too much, or sends no request
        else:
            # The kernel reports when there are more bytes than these.
            self._sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, len(data) + 1)
            asyncio.get_event_loop().add_reader(self._sock, self._on_bytes, len(data))

    def _stop_reading(self) -> None:
        asyncio.get_event_loop().remove_reader(self._sock)
        self._sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, 1)

    async def _begin(self) -> None:
        """Makes the transport; with TLS, this includes the handshake."""
        self._listener.admissions.count(self, self.place)  # older connections are ended first
        loop = cast(asyncio.BaseEventLoop, asyncio.get_event_loop())
        try:
            await loop.connect_accepted_socket(lambda: self, self._sock, **self._listener.options)
        except (OSError, asyncio.TimeoutError):  # ssl.SSLError is an OSError
            self._listener.left(self)
            self._sock.close()

    # -- the protocol of asyncio -------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Waits for the first request."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        self.inner = self._listener.protocol()
        self._listener.by_protocol[self.inner] = self
        self._end_after(HEAD_WITHIN)
        self.inner.connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Passes bytes of a request."""
        text = self._tail + data
        self._tail = text[-_KEPT:]
        if _ENCODING.search(text) is not None and self._transport is not None:
            self._transport.write(_REFUSED_ENCODING)
            self._transport.close()
            return
        if self._is_idle:
            self._is_idle = False
            self._end_after(HEAD_WITHIN)
        self.inner.data_received(data)

    def eof_received(self) -> None:
        """Notes that the other side sends nothing more. The connection ends."""
        self.inner.eof_received()

    def connection_lost(self, error: Optional[Exception]) -> None:
        """Notes that the connection has ended."""
        self._stop_timer()
        self._listener.by_protocol.pop(self.inner, None)
        self._listener.left(self)
        self.inner.connection_lost(error)
        if self._work is not None:
            self._work.cancel()

    def pause_writing(self) -> None:
        """Notes that the other side reads slowly."""
        self.inner.pause_writing()

    def resume_writing(self) -> None:
        """Notes that the other side has read."""
        self.inner.resume_writing()

    # -- what the door says about the connection ---------------------------------------------------

    @contextlib.contextmanager
    def serving(self, is_known: bool) -> Any:
        """Serves one request; `is_known`: a person sent it, so the connection is not ended."""
        self._is_idle = False
        if is_known:
            self._stop_timer()
            self._listener.admissions.leave(self)
        else:
            self._end_after(STRANGER_WITHIN)
        try:
            yield
        finally:
            self._is_idle, self._tail = True, b''
            if self._listener.by_protocol.get(self.inner) is self:
                self._end_after(IDLE)
                if is_known:
                    self._listener.admissions.count(self, self.place)

    def work_with(self, work: asyncio.Future[Any]) -> None:
        """Notes the work of the connection. If the connection ends before the work, the work is
        cancelled.
        """
        self._work = work

    def end(self) -> None:
        """Ends the connection at once, even in its TLS handshake."""
        if self._transport is not None:
            self._transport.abort()
        elif self._begun is not None:
            with contextlib.suppress(OSError):  # it may have ended already
                self._sock.shutdown(socket.SHUT_RDWR)
        else:
            self._stop_timer()
            self._listener.left(self)
            asyncio.get_event_loop().remove_reader(self._sock)
            self._sock.close()

    def _end_after(self, seconds: float) -> None:
        self._stop_timer()
        self._timer = asyncio.get_event_loop().call_later(seconds, self.end)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


class DoorListener:
    """Accepts connections at one address, within the limits of `Admissions`."""

    def __init__(self, protocol: Callable[[], asyncio.Protocol],
                 certificates: Optional[ssl.SSLContext]) -> None:
        self.protocol = protocol
        self.is_whole: Callable[[bytes], bool] = _is_head if certificates is None else _is_record
        self.is_foreign: Callable[[bytes], bool] = (
            _is_never if certificates is None else _cannot_be_record)
        self.options: Dict[str, Any] = {} if certificates is None else {
            'ssl': certificates, 'ssl_handshake_timeout': HEAD_WITHIN}
        self.admissions = Admissions()
        self.by_protocol: Dict[Any, Connection] = {}
        self._open: Set[Connection] = set()
        self._socket: Optional[socket.socket] = None

    def listen(self, host: str, port: int) -> int:
        """Begins to accept connections. Returns the port. Raises OSError."""
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        self._socket = socket.socket(family, kind, protocol)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._socket.bind(address)
            self._socket.listen(BACKLOG)
        except OSError:
            self._socket.close()
            raise
        self._socket.setblocking(False)
        asyncio.get_event_loop().add_reader(self._socket, self._accept)
        return int(self._socket.getsockname()[1])

    def close(self) -> None:
        """Stops accepting connections, and ends all open connections."""
        if self._socket is not None:
            asyncio.get_event_loop().remove_reader(self._socket)
            self._socket.close()
            self._socket = None
        for connection in tuple(self._open):
            connection.end()

    def left(self, connection: Connection) -> None:
        """Notes that a connection has ended."""
        self.admissions.leave(connection)
        self._open.discard(connection)

    def _accept(self) -> None:
        admitted = 0
        for _ in range(_AT_ONCE):
            if self._socket is None or admitted == _ADMITTED_AT_ONCE:
                return
            try:
                sock, address = self._socket.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                self._pause(error)
                return
            admitted += self._arrived(sock, place_of(address[0]))

    def _arrived(self, sock: socket.socket, place: str) -> bool:
        """Lets a new connection in or ends it. Returns whether it was let in."""
        sock.setblocking(False)
        if self.admissions.must_bring_request(place, time.monotonic()) and not (
                self.is_whole(_peek(sock) or b'')):
            sock.close()
            return False
        connection = Connection(self, sock, place)
        self._open.add(connection)
        displaced = self.admissions.arrive(connection, place)
        if isinstance(displaced, Connection):
            displaced.end()
        connection.wait_for_head()
        return True

    def _pause(self, error: OSError) -> None:
        """Accepts nothing for a moment, because the operating system has no connection left."""
        _LOG.warning('The page cannot accept a connection (%s).', error)
        loop, sock = asyncio.get_event_loop(), self._socket
        if sock is not None:
            loop.remove_reader(sock)
            loop.call_later(_PAUSE, self._resume)

    def _resume(self) -> None:
        if self._socket is not None:
            asyncio.get_event_loop().add_reader(self._socket, self._accept)


def _peek(sock: socket.socket) -> Optional[bytes]:
    """Returns the bytes that have come, and leaves them in the socket. None: there are none yet;
    empty: the other side has ended the connection.
    """
    try:
        return sock.recv(LONGEST_HEAD, socket.MSG_PEEK)
    except (BlockingIOError, InterruptedError):
        return None
    except OSError:
        return b''


def _is_head(data: bytes) -> bool:
    """Returns whether the head of a request is complete."""
    return b'\r\n\r\n' in data or b'\n\n' in data


def _is_never(_: bytes) -> bool:
    return False


def _is_record(data: bytes) -> bool:
    """Returns whether the first record of TLS is complete."""
    return len(data) >= 5 and len(data) >= 5 + int.from_bytes(data[3:5], 'big')


def _cannot_be_record(data: bytes) -> bool:
    return data[:1] != _TLS_HANDSHAKE
