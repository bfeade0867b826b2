"""Accepts the connection that the robot opens to us, keeps it alive, and passes on its lines."""
from __future__ import annotations

import contextlib
import errno
import logging
import selectors
import socket
import time
from typing import Callable, List, NamedTuple, Optional

from omron_arcl.connection import ArclConnection, LivePeer, is_host, reason_of
from omron_arcl.host_addresses import HostAddresses
from omron_arcl.link import Link, LinkPhase
from omron_arcl.session import Received, Session
from omron_arcl.session_log import SessionLog
from omron_arcl.transport import Transport

KEEP_ALIVE = 2.0  # s; the robot drops a listener that is silent for 6 s by default
RETRY = 1.0  # s between two attempts to listen on a port, or to accept a connection
RIVALS = 3  # if so many live connections are replaced within RIVAL_TIME s, two robots compete
RIVAL_TIME = 30.0
_LIVELY = 1.0  # s; for so long after its last line, a connection counts as alive
_RIVALRY = ('two robots, or two programs, connect from this address in turn: give each robot an '
            'address and a port of its own')
_MAXIMUM_UNSENT = 64  # bytes of keep-alive to a robot that does not read
_MAXIMUM_GUESTS = 4  # connections that wait until the addresses of the robot are known
_log = logging.getLogger(__name__)


class _Guest(NamedTuple):
    """A connection for which it is not yet known whether the robot opened it."""

    socket: socket.socket
    host: str
    port: int
    since: float


class Listener(Transport):
    """Waits for the robot's outgoing connection until `close`; a new connection replaces the last.

    robot: name or address of the only host that may connect. on_line(Received): a line came.
    on_link(Link): the link changed. on_refused(str): a peer with this address was rejected, because
    it is not the robot. timeout: s; after a longer time without a line, the connection is dead.

    If live connections replace each other in turn, the reason of the connected link says so. If
    another program uses the port, the reason of the link says so, and the listener tries again
    until the port is free. Raises OSError if it can never listen at (bind, port).

    The class has many attributes because one thread keeps one port with its parts, callbacks and
    times.
    """

    def __init__(self, bind: str, port: int, robot: str, *,
                 on_line: Optional[Callable[[Received], None]] = None,
                 on_link: Optional[Callable[[Link], None]] = None,
                 on_refused: Optional[Callable[[str], None]] = None,
                 log: Optional[SessionLog] = None,
                 timeout: float = 4.0) -> None:
        self._robot = robot
        self._on_line = on_line
        self._on_refused = on_refused
        self._trace = log.outgoing() if log else None
        self._timeout = timeout
        self._bind = bind
        self.port = port
        self._socket: Optional[socket.socket] = None
        self._peer: Optional[LivePeer] = None
        self._guests: List[_Guest] = []
        self._due = time.monotonic() + RETRY  # time of the next attempt to listen
        self._spoken = 0.0
        self._replaced: List[float] = []  # when live connections were replaced
        reason = 'the robot has not connected yet'
        try:
            self._socket = self._listen()
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
            reason = (f'another program has port {port}: end it or choose another port; the next '
                      'attempt follows every second')
        super().__init__('ARCL listener', Link(LinkPhase.DISCONNECTED, robot, reason), on_link)
        self._addresses = HostAddresses(robot, self._waker.wake)

    def _listen(self) -> socket.socket:
        if self._bind and not is_host(self._bind):
            raise OSError(errno.EINVAL, 'that is neither an address nor a name')
        listening = socket.create_server((self._bind, self.port), backlog=4)
        listening.setblocking(False)
        self.port = listening.getsockname()[1]
        return listening

    def _free(self) -> None:
        super()._free()
        self._addresses.close()
        for guest in self._guests:
            guest.socket.close()
        if self._socket:
            self._socket.close()

    # --- the listener's thread -------------------------------------------------------------------

    def _run(self) -> None:
        self._call(self._on_link, self.link)
        self._addresses.start()
        with selectors.DefaultSelector() as selector:
            selector.register(self._waker.reader, selectors.EVENT_READ)
            if self._socket:
                selector.register(self._socket, selectors.EVENT_READ)
            while not self._closing.is_set():
                waited = self._wait(selector)
                now = time.monotonic()
                if self._socket is None:
                    self._listen_again(selector, now)
                elif self._socket in self._ready:
                    self._accept(self._socket, selector, now)
                elif now >= self._due and self._socket not in selector.get_map():
                    selector.register(self._socket, selectors.EVENT_READ)
                self._admit_guests(selector, now)
                if self._peer:
                    self._serve(self._peer, selector, now, waited)
            self._drop(selector, 'closed by us')

    def _listen_again(self, selector: selectors.BaseSelector, now: float) -> None:
        if now < self._due:
            return
        self._due = now + RETRY
        with contextlib.suppress(OSError):  # the link already says why
            self._socket = self._listen()
            selector.register(self._socket, selectors.EVENT_READ)
            self._set_link(LinkPhase.DISCONNECTED, self._robot, f'port {self.port} is free now, '
                           'but the robot has not connected yet')

    def _accept(self, listening: socket.socket, selector: selectors.BaseSelector,
                now: float) -> None:
        try:
            accepted, address = listening.accept()
        except BlockingIOError:  # the peer has closed it already
            return
        except OSError as error:  # no descriptors are left: a retry at once would fail, too
            _log.warning('A connection could not be accepted: %s.', reason_of(error))
            selector.unregister(listening)
            self._due = now + RETRY
            return
        self._guests.append(_Guest(accepted, address[0], address[1], now))
        if len(self._guests) > _MAXIMUM_GUESTS:
            self._guests.pop(0).socket.close()

    def _admit_guests(self, selector: selectors.BaseSelector, now: float) -> None:
        waiting, self._guests = self._guests, []
        for guest in waiting:
            is_robots = self._addresses.belongs(guest.host, guest.since)
            if is_robots is None:
                self._guests.append(guest)
            elif is_robots:
                self._admit(guest, selector, now)
            else:
                guest.socket.close()
                self._call(self._on_refused, guest.host)

    def _admit(self, guest: _Guest, selector: selectors.BaseSelector, now: float) -> None:
        try:
            connection = ArclConnection(guest.socket)
        except OSError:  # closed by the peer already
            guest.socket.close()
            return
        if self._peer and self._peer.is_lively(now, _LIVELY):
            self._replaced.append(now)
        self._replaced = [then for then in self._replaced if now - then < RIVAL_TIME]
        self._drop(selector, 'the robot opened a new connection')
        self._peer = LivePeer(connection, Session(None, trace=self._trace), self._timeout)
        self._spoken = now
        selector.register(guest.socket, selectors.EVENT_READ)
        self._set_link(LinkPhase.CONNECTED, f'{guest.host}:{guest.port}',
                       _RIVALRY if len(self._replaced) >= RIVALS else '')

    def _serve(self, peer: LivePeer, selector: selectors.BaseSelector, now: float,
               waited: float) -> None:
        try:
            for event in peer.receive(now, waited):
                self._call(self._on_line, event)
            if now - self._spoken > KEEP_ALIVE:
                self._spoken = now
                unsent = len(peer.connection.unsent)
                peer.connection.send(b'\n' if unsent < _MAXIMUM_UNSENT else b'')
        except Exception as error:  # without this the thread would end and never listen again
            self._drop(selector, str(self._cause(error)))

    def _drop(self, selector: selectors.BaseSelector, reason: str) -> None:
        if self._peer:
            selector.unregister(self._peer.connection.socket)
            self._peer.connection.close()
            self._peer = None
            self._set_link(LinkPhase.DISCONNECTED, self.link.peer, reason)
