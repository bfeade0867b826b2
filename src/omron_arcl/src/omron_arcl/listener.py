"""The connection that the robot opens to us: take it, keep it alive, hand on its lines."""
from __future__ import annotations

import contextlib
import errno
import logging
import selectors
import socket
import time
from typing import Callable, Optional

from omron_arcl.connection import TICK, Connection, Transport, reason_of
from omron_arcl.errors import ConnectionLost, LinkError, PeerSilent
from omron_arcl.link import Link, LinkPhase
from omron_arcl.session import Closed, Received, Session
from omron_arcl.session_log import SessionLog

KEEP_ALIVE = 2.0  # s; the robot drops a listener that is silent for 6 s by default
RETRY = 1.0  # s between two tries to listen on a port that another program has
_MOST_UNSENT = 64  # bytes of keep-alive to a robot that does not read
_log = logging.getLogger(__name__)


class Listener(Transport):
    """Waits for the robot's outgoing connection until `close`; the last connection counts.

    robot: name or address of the only host that may connect. on_line(Received): a line came.
    on_link(Link): the link changed. on_refused(str): somebody else, with this address, was turned
    away. silence: seconds without a byte after which the connection counts as dead.
    A port that another program has is tried again until it is free, and the link says so meanwhile.
    Raises OSError where it can never listen at (bind, port).
    """

    def __init__(self, bind: str, port: int, robot: str, *,
                 on_line: Optional[Callable[[Received], None]] = None,
                 on_link: Optional[Callable[[Link], None]] = None,
                 on_refused: Optional[Callable[[str], None]] = None,
                 log: Optional[SessionLog] = None,
                 silence: float = 4.0) -> None:
        super().__init__('ARCL listener')
        self._robot = robot
        self._on_line = on_line
        self._on_link = on_link
        self._on_refused = on_refused
        self._trace = log.outgoing() if log else None
        self._silence = silence
        self._bind = bind
        self.port = port
        self._socket: Optional[socket.socket] = None
        self._tried = time.monotonic()
        self.link = Link(LinkPhase.DISCONNECTED, robot, 'the robot has not connected yet')
        self._connection: Optional[Connection] = None
        self._session = Session(None)
        self._heard = self._spoken = 0.0
        try:
            self._listen()
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
            self.link = Link(LinkPhase.DISCONNECTED, robot, f'another program has port {port}: '
                             'end it or choose another port; it is tried again every second')

    def _listen(self) -> None:
        self._socket = socket.create_server((self._bind, self.port), backlog=4)
        self._socket.setblocking(False)
        self.port = self._socket.getsockname()[1]

    # --- the listener's thread -------------------------------------------------------------------

    def _run(self) -> None:
        self._call(self._on_link, self.link)
        with selectors.DefaultSelector() as selector:
            self._selector = selector
            selector.register(self._waker.reader, selectors.EVENT_READ)
            if self._socket:
                selector.register(self._socket, selectors.EVENT_READ)
            while not self._closing.is_set():
                ready = [key.fileobj for key, _ in selector.select(TICK)]
                if not self._socket:
                    self._retry(time.monotonic())
                elif self._socket in ready:
                    self._accept()
                if self._connection:
                    self._serve(time.monotonic())
            self._drop(ConnectionLost('closed by us'))
        if self._socket:
            self._socket.close()

    def _retry(self, now: float) -> None:
        if now - self._tried < RETRY:
            return
        self._tried = now
        with contextlib.suppress(OSError):  # why has been said
            self._listen()
            self._selector.register(self._socket, selectors.EVENT_READ)
            self._set_link(Link(LinkPhase.DISCONNECTED, self._robot, f'port {self.port} is free '
                                'now, the robot has not connected yet'))

    def _accept(self) -> None:
        try:
            accepted, address = self._socket.accept()
        except OSError as error:  # it was gone again, or there are no descriptors left
            _log.warning('A connection could not be taken: %s.', reason_of(error))
            return
        if not self._is_robot(address[0]):
            accepted.close()
            self._call(self._on_refused, address[0])
            return
        try:
            connection = Connection(accepted)
        except OSError:  # gone already
            accepted.close()
            return
        self._drop(ConnectionLost('the robot connected anew'))
        self._connection = connection
        self._session = Session(None, trace=self._trace)
        self._heard = self._spoken = time.monotonic()
        self._selector.register(accepted, selectors.EVENT_READ)
        self._set_link(Link(LinkPhase.CONNECTED, '{}:{}'.format(*address[:2])))

    def _is_robot(self, address: str) -> bool:
        try:
            return address in {entry[4][0] for entry in socket.getaddrinfo(self._robot, None)}
        except OSError as error:
            _log.warning('The name %s has no address: %s.', self._robot, reason_of(error))
            return False

    def _serve(self, now: float) -> None:
        try:
            data = self._connection.receive()
            if data is None:
                if now - self._heard > self._silence:
                    raise PeerSilent(now - self._heard)
            else:
                self._heard = now
                for event in self._session.read(data) if data else self._session.receive_eof():
                    if isinstance(event, Closed):
                        raise event.cause
                    self._call(self._on_line, event)
            if now - self._spoken > KEEP_ALIVE:
                self._spoken = now
                self._connection.send(b'\n' if len(self._connection.unsent) < _MOST_UNSENT else b'')
        except Exception as error:  # a thread that died of it could never listen again
            self._drop(self._cause(error))

    def _drop(self, cause: LinkError) -> None:
        if self._connection:
            self._selector.unregister(self._connection.socket)
            self._connection.close()
            self._connection = None
            self._set_link(Link(LinkPhase.DISCONNECTED, self.link.peer, str(cause)))

    def _set_link(self, link: Link) -> None:
        self.link = link
        self._call(self._on_link, link)
