"""The link to an ARCL server: connects, logs in, and connects again after each loss.

The link serves a user: `Client` for a robot, or `JobHandover` of omron_jobs for a Fleet Manager.
The user provides the lines to send and receives the lines that come. One thread owns the socket,
and calls the user.
"""
from __future__ import annotations

import selectors
import time
from typing import Callable, Optional, Protocol, Union

from omron_arcl.connection import ArclConnection, LivePeer, reason_of
from omron_arcl.errors import ConnectionFailed, ConnectionLost, LinkError, WrongPassword
from omron_arcl.link import Backoff, Link, LinkPhase
from omron_arcl.secret import redact_passwords
from omron_arcl.session import LoggedIn, Received, Session, SessionState, Trace
from omron_arcl.session_log import SessionLog
from omron_arcl.transport import Transport

CONNECT_TIMEOUT = 3.0  # s, for each address of the server
LOGIN_TIMEOUT = 15.0  # s from the connection to the end of the login
LOGIN_SILENCE = 4.0  # s; a login fails after so long without a line (`silence`, if longer)


class LinkUser(Protocol):
    """The user of a link. The link's thread calls it from a login until the loss of the link."""

    def hear_login(self, login: LoggedIn, now: float) -> None:
        """Notes that the link is logged in."""

    def hear_line(self, line: Received, now: float) -> None:
        """Notes a line that came after the login."""

    def hear_turn(self, now: float) -> None:
        """Notes that all received lines are handled, or that none came for a short time.

        Raises LinkError to end the connection.
        """

    def next_to_send(self, now: float) -> Optional[bytes]:
        """Returns the next line to be sent; None: there is none. Called when all earlier lines are
        sent.
        """

    def hear_loss(self, cause: LinkError) -> None:
        """Notes that the link has ended, or could not be made. Also called without a login."""


class ArclLink(Transport):
    """Connects to a server again and again until `close`.

    silence -- s; after a longer time without a line, the link counts as dead
    log     -- records all lines of both sides
    resets  -- whether the connection is reset when it closes, even by a killed process: the kernel
               then drops undelivered data

    The class has many attributes because one thread keeps one connection with its address, times
    and user.
    """

    def __init__(self, name: str, host: str, port: int, password: bytes, user: LinkUser, *,
                 silence: float, on_link: Optional[Callable[[Link], None]] = None,
                 log: Optional[SessionLog] = None, backoff: Optional[Backoff] = None,
                 resets: bool = False) -> None:
        self.peer = f'{host}:{port}'
        super().__init__(name, Link(LinkPhase.DISCONNECTED, self.peer, 'not started'), on_link)
        self._address, self._password, self._user = (host, port), password, user
        self._silence, self._log, self._resets = silence, log, resets
        self._backoff = backoff or Backoff()
        self._trace: Optional[Trace] = None

    def wake(self) -> None:
        """Makes the link ask its user at once for lines to send. Any thread may call this."""
        self._waker.wake()

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                cause = self._converse()
            except Exception as error:  # without this the thread would end and never reconnect
                cause = self._cause(error)
            self._set_link(LinkPhase.WRONG_PASSWORD if isinstance(cause, WrongPassword)
                           else LinkPhase.DISCONNECTED, self.peer, str(cause))
            self._call(self._user.hear_loss, cause)
            self._closing.wait(self._backoff.after(cause))

    def _converse(self) -> LinkError:
        """Serves one connection from beginning to end; returns or raises the cause of the end."""
        self._set_link(LinkPhase.CONNECTING, self.peer, 'connecting')
        try:
            connection = ArclConnection.open(*self._address, CONNECT_TIMEOUT, self._closing.is_set)
        except OSError as error:
            return ConnectionFailed(f'cannot connect: {reason_of(error)}')
        self._set_link(LinkPhase.LOGGING_IN, self.peer, 'logging in')
        with connection, selectors.DefaultSelector() as selector:
            if self._resets:
                connection.reset_when_closed()
            selector.register(connection.socket, selectors.EVENT_READ)
            selector.register(self._waker.reader, selectors.EVENT_READ)
            self._trace = self._log.connection() if self._log else None
            session = Session(self._password, trace=self._trace)
            self._log_in(connection, session, selector)
            peer = LivePeer(connection, session, self._silence)
            while not self._closing.is_set():
                self._user.hear_turn(self._turn(peer, selector))
            return ConnectionLost('closed by us')

    def _log_in(self, connection: ArclConnection, session: Session,
                selector: selectors.BaseSelector) -> None:
        """Runs until the session is ready; raises LinkError or OSError."""
        peer = LivePeer(connection, session, max(self._silence, LOGIN_SILENCE))
        began = time.monotonic()
        while session.state is not SessionState.READY and not self._closing.is_set():
            now = self._turn(peer, selector)
            if now - began > LOGIN_TIMEOUT:
                words = f'; the server said "{session.words}"' if session.words else ''
                raise ConnectionFailed(f'the login took more than {LOGIN_TIMEOUT:.0f} s{words}')

    def _turn(self, peer: LivePeer, selector: selectors.BaseSelector) -> float:
        """Sends pending data, waits for an event, processes it; returns the time after the wait."""
        self._send(peer)
        selector.modify(peer.connection.socket, selectors.EVENT_READ
                        | (selectors.EVENT_WRITE if peer.connection.unsent else 0))
        waited = self._wait(selector)
        now = time.monotonic()
        for event in peer.receive(now, waited):
            self._handle(event, now)
        for timed in peer.session.on_time(now):
            if isinstance(timed, (LoggedIn, Received)):
                self._handle(timed, now)
        return now

    def _send(self, peer: LivePeer) -> None:
        """Sends pending lines, one command at a time, so that a stop overtakes all others."""
        peer.connection.send(peer.session.pop_output())
        while not peer.connection.unsent and peer.session.state is SessionState.READY:
            line = self._user.next_to_send(time.monotonic())
            if line is None:
                return
            if self._trace:
                self._trace('C', redact_passwords(line))
            peer.connection.send(line + b'\n')

    def _handle(self, event: Union[LoggedIn, Received], now: float) -> None:
        if isinstance(event, Received):
            self._user.hear_line(event, now)
        else:
            self._backoff.reset()
            self._user.hear_login(event, now)
            self._set_link(LinkPhase.CONNECTED, self.peer)
