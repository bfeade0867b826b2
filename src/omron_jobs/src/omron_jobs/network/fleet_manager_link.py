"""The link to an OMRON Fleet Manager: logs in, sends what is due, hands over each line.

Connection, login and password are those of `omron_arcl`. The socket is reset when it closes, also
when the process dies: the kernel drops what it has not delivered, so no command of an old link
arrives after the question of the next one.
"""
from __future__ import annotations

import selectors
import socket
import struct
import time
from typing import Callable, Iterable, List, Optional, Protocol

from omron_arcl import Backoff, Link, LinkError, LinkPhase, Received
from omron_arcl.connection import ArclConnection, LivePeer, reason_of
from omron_arcl.errors import ConnectionFailed, ConnectionLost, WrongPassword
from omron_arcl.session import LoggedIn, Session, SessionState
from omron_arcl.transport import Transport

CONNECT_TIMEOUT = 3.0   # s, for each address
LOGIN_TIMEOUT = 15.0    # s from the connection to the end of the login
SILENCE = 6.0           # s without a line after which the link counts as lost
BEAT = 1.5              # s between two requests for a sign of life
_SIGN_OF_LIFE = b'getDateTime'
_RESET = struct.pack('ii', 1, 0)    # SO_LINGER with time 0: closing sends RST


class LinkUser(Protocol):
    """The user of the link; the link's thread calls it."""

    def hear_login(self) -> None:
        """The link is logged in."""

    def hear_loss(self) -> None:
        """The link has ended, or could not be made."""

    def hear_line(self, text: str, now: float) -> None:
        """A line came after the login."""

    def due(self, now: float) -> Iterable[str]:
        """The lines that are to be sent now."""

    def is_stuck(self, now: float) -> bool:
        """Whether the link is to be given up."""


class FleetManagerLink(Transport):
    """Connects again after each loss until `close`. `wake` lets it ask for what is due."""

    def __init__(self, host: str, port: int, password: bytes, user: LinkUser,
                 on_link: Optional[Callable[[Link], None]] = None,
                 backoff: Optional[Backoff] = None) -> None:
        self.peer = f'{host}:{port}'
        super().__init__('Fleet Manager link',
                         Link(LinkPhase.DISCONNECTED, self.peer, 'not started'), on_link)
        self._address, self._password, self._user = (host, port), password, user
        self._backoff = backoff or Backoff()

    def wake(self) -> None:
        """Makes the link ask at once for what is due; for any thread."""
        self._waker.wake()

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                cause = self._converse()
            except Exception as error:  # without this the thread would end and never reconnect
                cause = self._cause(error)
            self._call(self._user.hear_loss)
            self._set_link(LinkPhase.WRONG_PASSWORD if isinstance(cause, WrongPassword)
                           else LinkPhase.DISCONNECTED, self.peer, str(cause))
            self._closing.wait(self._backoff.after(cause))

    def _converse(self) -> LinkError:
        """Serves one connection from beginning to end; returns or raises why it ended."""
        self._set_link(LinkPhase.CONNECTING, self.peer, 'connecting')
        try:
            connection = ArclConnection.open(*self._address, CONNECT_TIMEOUT, self._closing.is_set)
        except OSError as error:
            return ConnectionFailed(f'cannot connect: {reason_of(error)}')
        self._set_link(LinkPhase.LOGGING_IN, self.peer, 'logging in')
        with connection, selectors.DefaultSelector() as selector:
            connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
            selector.register(connection.socket, selectors.EVENT_READ)
            selector.register(self._waker.reader, selectors.EVENT_READ)
            peer = LivePeer(connection, Session(self._password), SILENCE)
            return self._talk(peer, selector)

    def _talk(self, peer: LivePeer, selector: selectors.BaseSelector) -> LinkError:
        began = beat = time.monotonic()
        while not self._closing.is_set():
            now = self._turn(peer, selector)
            if peer.session.state is not SessionState.READY:
                if now - began > LOGIN_TIMEOUT:
                    return ConnectionFailed(f'the login took more than {LOGIN_TIMEOUT:.0f} s')
                continue
            lines: List[bytes] = [line.encode('ascii') for line in self._user.due(now)]
            if now - beat >= BEAT:
                beat = now
                lines.append(_SIGN_OF_LIFE)
            peer.connection.send(b''.join(line + b'\n' for line in lines))
            if self._user.is_stuck(now):
                return ConnectionLost('the Fleet Manager does not answer')
        return ConnectionLost('closed by us')

    def _turn(self, peer: LivePeer, selector: selectors.BaseSelector) -> float:
        """Sends the login's data, waits for an event, handles what came; returns the time then."""
        peer.connection.send(peer.session.take_output())
        selector.modify(peer.connection.socket, selectors.EVENT_READ
                        | (selectors.EVENT_WRITE if peer.connection.unsent else 0))
        waited = self._wait(selector)
        now = time.monotonic()
        for event in (*peer.receive(now, waited), *peer.session.on_time(now)):
            if isinstance(event, Received):
                self._user.hear_line(event.text, now)
            elif isinstance(event, LoggedIn):
                self._backoff.reset()
                self._user.hear_login()
                self._set_link(LinkPhase.CONNECTED, self.peer)
        return now
