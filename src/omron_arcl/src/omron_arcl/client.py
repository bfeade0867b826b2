"""The connection to the robot's ARCL server: log in, stay logged in, carry commands.

One thread owns the socket. It tells what comes through callbacks, which it calls itself, without
locks held: they may give commands, and must be short.
"""
from __future__ import annotations

import contextlib
import selectors
import threading
import time
from typing import Callable, Optional

from omron_arcl.command_line import parse_command
from omron_arcl.connection import TICK, Connection, Transport, reason_of
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.errors import (
    Busy,
    ConnectionFailed,
    ConnectionLost,
    LinkError,
    NotConnected,
    PeerSilent,
    WrongPassword,
)
from omron_arcl.execution import Execution, Result
from omron_arcl.link import Backoff, Link, LinkPhase
from omron_arcl.secret import blank_configured
from omron_arcl.session import (
    Closed,
    Event,
    HelpList,
    LoggedIn,
    Received,
    Session,
    State,
    Trace,
)
from omron_arcl.session_log import SessionLog

CONNECT_TIMEOUT = 3.0  # s
LOGIN_TIMEOUT = 15.0  # s from the connection to the end of the help list
HEARTBEAT = 'oneLineStatus'  # any answer is a sign of life, an "Unknown command" too


class Client(Transport):
    """A robot's ARCL server, connected to for ever until `close`.

    on_line(Received): a line came after the login. on_link(Link): the link changed.
    on_login(HelpList): logged in, once per connection. log: takes all that both sides say.
    heartbeat: seconds between signs of life asked of the robot; silence: seconds without any, after
    which the link counts as dead.
    """

    def __init__(self, host: str, port: int, password: bytes, *,
                 on_line: Optional[Callable[[Received], None]] = None,
                 on_link: Optional[Callable[[Link], None]] = None,
                 on_login: Optional[Callable[[HelpList], None]] = None,
                 log: Optional[SessionLog] = None, backoff: Optional[Backoff] = None,
                 heartbeat: float = 1.5, silence: float = 4.0) -> None:
        super().__init__('ARCL client')
        self.peer = f'{host}:{port}'
        self._address = (host, port)
        self._password = password
        self._on_line = on_line
        self._on_link = on_link
        self._on_login = on_login
        self._log = log
        self._trace: Optional[Trace] = None
        self._backoff = backoff or Backoff()
        self._heartbeat = heartbeat
        self._silence = silence

        self.link = Link(LinkPhase.DISCONNECTED, self.peer, 'not started')
        self.help = HelpList({})
        self._pulse: Optional[Execution] = None
        self._beat_due = 0.0
        self._lock = threading.Lock()  # guards link, help, _dispatcher
        self._dispatcher = Dispatcher()
        self._answered = threading.Event()  # the password was taken, or refused

    # --- for any thread --------------------------------------------------------------------------

    def wait_connected(self, timeout: float) -> Link:
        """Waits until logged in or refused, `timeout` s at most; the link then."""
        self._answered.wait(timeout)
        return self.link

    def execute(self, text: str, *, timeout: Optional[float] = None,
                on_line: Optional[Callable[[str], None]] = None,
                on_end: Optional[Callable[[Result], None]] = None) -> Execution:
        """Gives a command, e.g. `goto 12`. Raises InvalidCommand, NotConnected or Busy.

        timeout: seconds without a word about it after which it counts as timed out, else the
        command's own. on_line, on_end: called by the client's thread.
        """
        with self._lock:
            if not self.link.connected:
                raise NotConnected(self.link.reason or self.link.phase.value)
            command = parse_command(text, self.help.full_name)
            execution = self._dispatcher.start(command, timeout, on_line, on_end)
        self._waker.wake()
        return execution

    def cancel(self, execution: Execution) -> None:
        """Ends a command; a driving one by stopping the robot. Its result tells when it is over."""
        with self._lock:
            self._dispatcher.cancel(execution)
        self._waker.wake()

    # --- the thread of the client ----------------------------------------------------------------

    def _run(self) -> None:
        while not self._closing.is_set():
            cause = self._converse()
            self._lost(cause)
            self._closing.wait(self._backoff.after(cause))

    def _converse(self) -> LinkError:
        """One connection from beginning to end; returns why it ended."""
        self._answered.clear()
        self._set_link(LinkPhase.CONNECTING, 'connecting')
        try:
            connection = Connection.open(*self._address, CONNECT_TIMEOUT, self._closing.is_set)
        except OSError as error:
            return ConnectionFailed(f'cannot connect: {reason_of(error)}')
        self._set_link(LinkPhase.LOGGING_IN, 'logging in')
        with connection, selectors.DefaultSelector() as selector:
            selector.register(connection.socket, selectors.EVENT_READ)
            selector.register(self._waker.reader, selectors.EVENT_READ)
            try:
                return self._talk(connection, selector)
            except Exception as error:  # a thread that died of it could never connect again
                return self._cause(error)

    def _talk(self, connection: Connection, selector: selectors.BaseSelector) -> LinkError:
        self._trace = self._log.connection() if self._log else None
        session = Session(self._password, trace=self._trace)
        began = heard = time.monotonic()
        while not self._closing.is_set():
            self._send(connection, session)
            selector.modify(connection.socket, selectors.EVENT_READ
                            | (selectors.EVENT_WRITE if connection.unsent else 0))
            selector.select(TICK)
            self._waker.drain()
            data = connection.receive()
            now = time.monotonic()
            if data is not None:
                heard = now
                for event in session.read(data) if data else session.receive_eof():
                    if isinstance(event, Closed):
                        return event.cause
                    self._handle(event, now)
            elif now - heard > self._silence:
                raise PeerSilent(now - heard)
            if session.state is not State.READY and now - began > LOGIN_TIMEOUT:
                raise ConnectionFailed(f'the login took more than {LOGIN_TIMEOUT:.0f} s')
            with self._lock:
                self._dispatcher.on_time(now)
            self._beat(now)
            self._tell_news()
        return ConnectionLost('closed by us')

    def _send(self, connection: Connection, session: Session) -> None:
        """Sends what is due; one command at a time, so that a stop passes all others."""
        connection.send(session.take_output())
        while not connection.unsent and session.state is State.READY:
            with self._lock:
                text = self._dispatcher.next_to_send(time.monotonic())
            if text is None:
                return
            line = text.encode('ascii')
            if self._trace:
                self._trace('C', blank_configured(line))
            connection.send(line + b'\n')

    def _handle(self, event: Event, now: float) -> None:
        if isinstance(event, Received):
            self._call(self._on_line, event)
            with self._lock:
                self._dispatcher.on_reply(event.reply, event.text, now)
        elif isinstance(event, LoggedIn):
            self._backoff.reset()
            self.help = event.help
            self._beat_due = now + self._heartbeat
            self._set_link(LinkPhase.CONNECTED)
            self._answered.set()
            self._call(self._on_login, event.help)

    def _beat(self, now: float) -> None:
        """Asks for a sign of life when it is time and none is awaited."""
        if self.link.connected and now >= self._beat_due and (
                self._pulse is None or self._pulse.result is not None):
            self._beat_due = now + self._heartbeat
            with contextlib.suppress(Busy):  # with so much to say there are signs of life enough
                self._pulse = self.execute(HEARTBEAT)

    def _lost(self, cause: LinkError) -> None:
        refused = isinstance(cause, WrongPassword)
        if not refused:
            self._answered.clear()
        self._set_link(LinkPhase.WRONG_PASSWORD if refused else LinkPhase.DISCONNECTED, str(cause))
        if refused:
            self._answered.set()
        with self._lock:
            self._dispatcher.on_lost(str(cause))
        self._tell_news()

    def _set_link(self, phase: LinkPhase, reason: str = '') -> None:
        with self._lock:
            self.link = Link(phase, self.peer, reason)
        self._call(self._on_link, self.link)

    def _tell_news(self) -> None:
        with self._lock:
            news = self._dispatcher.take_news()
        for tell in news:
            self._call(tell)
