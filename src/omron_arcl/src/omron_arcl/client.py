"""The connection to the robot's ARCL server: logs in, keeps the login, sends commands.

One thread owns the socket. It reports lines and results through callbacks. It calls them itself,
without locks, so a callback may give commands. A callback must be short.
"""
from __future__ import annotations

import contextlib
import math
import selectors
import threading
import time
from typing import Callable, Dict, Mapping, Optional, Union

from omron_arcl.command_line import parse_command
from omron_arcl.commands import Command
from omron_arcl.connection import ArclConnection, LivePeer, reason_of
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.drives import Drives
from omron_arcl.errors import (
    Busy,
    ConnectionFailed,
    ConnectionLost,
    LinkError,
    NotConnected,
    StopOwed,
    WrongPassword,
)
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome, Result
from omron_arcl.help_list import HelpList
from omron_arcl.link import Backoff, Link, LinkPhase
from omron_arcl.records import RobotMotion
from omron_arcl.replies import Goal, Macro, MapChanged, Route
from omron_arcl.secret import redact_passwords
from omron_arcl.session import LoggedIn, Received, Session, SessionState, Trace
from omron_arcl.session_log import SessionLog
from omron_arcl.transport import Transport

CONNECT_TIMEOUT = 3.0  # s, for each address of the robot
LOGIN_TIMEOUT = 15.0  # s from the connection to the end of the login
LOGIN_SILENCE = 4.0  # s without a line in the login after which it has failed, at least
HEARTBEATS = ('oneLineStatus', 'status')  # the second for robots that do not have the first
_IN_DOUBT = 1.0  # s between heartbeats while a status would show whether a drive is over
_MAXIMUM_NAMES = 10_000


class Client(Transport):
    """The connection to a robot's ARCL server; connects again after each loss until `close`.

    on_line(Received): a line came after the login. on_link(Link): the link changed.
    on_login(HelpList): the login succeeded; called once per connection. log: records all lines of
    both sides. heartbeat: seconds between two requests for a sign of life. timeout: seconds without
    a sign of life after which the link counts as dead. `names`: the bytes of each name that the
    robot has listed and that is not ASCII. records: the records of the robot's
    drives. on_motion(Motion): the motion has changed; called by any thread.

    It has many attributes because one thread keeps one connection: its parts, callbacks and times.
    """

    def __init__(self, host: str, port: int, password: bytes, *,
                 on_line: Optional[Callable[[Received], None]] = None,
                 on_link: Optional[Callable[[Link], None]] = None,
                 on_login: Optional[Callable[[HelpList], None]] = None,
                 log: Optional[SessionLog] = None, backoff: Optional[Backoff] = None,
                 heartbeat: float = 1.5, timeout: float = 4.0,
                 records: Optional[Drives] = None,
                 on_motion: Optional[Callable[[RobotMotion], None]] = None) -> None:
        self.peer = f'{host}:{port}'
        super().__init__('ARCL client', Link(LinkPhase.DISCONNECTED, self.peer, 'not started'),
                         on_link)
        self._address = (host, port)
        self._password = password
        self._on_line = on_line
        self._on_login = on_login
        self._on_motion = on_motion
        self._told_motion: Optional[RobotMotion] = None
        self._telling = threading.Lock()  # keeps the calls of on_motion in order
        self._log = log
        self._trace: Optional[Trace] = None
        self._backoff = backoff or Backoff()
        self._heartbeat = heartbeat
        self._timeout = timeout

        self.help = HelpList({}, complete=False)
        self._names: Dict[str, bytes] = {}
        self._pulse: Optional[Execution] = None
        self._pulsed_at = 0.0
        self._heartbeats = list(HEARTBEATS)
        self._lock = threading.Lock()  # guards help, _names, _dispatcher
        self._dispatcher = Dispatcher(records)
        self._answered = threading.Event()  # the password was taken, or refused

    # --- for any thread --------------------------------------------------------------------------

    def wait_connected(self, timeout: float) -> Link:
        """Waits until logged in or refused, at most `timeout` s, and returns the link."""
        self._answered.wait(timeout)
        return self.link

    @property
    def names(self) -> Mapping[str, bytes]:
        """The bytes that the robot writes for each listed name that is not ASCII."""
        with self._lock:
            return dict(self._names)

    def execute(self, text: str, *, timeout: Optional[float] = None,
                on_line: Optional[Callable[[str], None]] = None,
                on_end: Optional[Callable[[Result], None]] = None,
                check: Optional[Callable[[Command], None]] = None,
                stop_on_timeout: bool = False, giver: Giver = NO_GIVER,
                known_epoch: int = 0, number: int = 0) -> Execution:
        """Gives a command, e.g. `goto 12`. Raises InvalidCommand, NotConnected, Busy, Overruled or
        Unclear. A stop that is given without a link becomes an owed stop: it is sent as soon as
        there is a link.

        timeout: seconds without a line about the command until it has timed out; default: the
        command's own timeout. on_line, on_end: called by the client's thread. check: called with
        the command before it is sent; raises ArclError if it must not be sent. stop_on_timeout:
        stops a drive that has timed out. known_epoch: the epoch that `giver` knows; 0 is for
        people, whose commands are valid in each epoch. number: of the command at its giver; it
        grows, and `motion` says what became of the last one.
        """
        with self._lock:
            command = parse_command(text, self.help.full_name, self._names)
        if check:
            check(command)
        try:
            with self._lock:
                link = self.link
                if not link.connected:
                    self._dispatcher.start_without_link(command, giver, known_epoch, number)
                    error = StopOwed if command.spec.stops else NotConnected
                    raise error(link.reason or link.phase.value)
                execution = self._dispatcher.start(command, timeout, on_line, on_end,
                                                   stop_on_timeout, giver, known_epoch, number)
        finally:
            self._tell_motion()
        self._waker.wake()
        return execution

    def cancel(self, execution: Execution, canceller: Giver = NO_GIVER) -> None:
        """Ends a command; stops the robot if it is a drive. Its `result` is set when it is over."""
        with self._lock:
            self._dispatcher.cancel(execution, time.monotonic(), canceller)
        self._tell_motion()
        self._waker.wake()

    def cancel_all(self, canceller: Giver) -> None:
        """Cancels all earlier commands on behalf of `canceller`, even if none is under way."""
        with self._lock:
            self._dispatcher.records.all_cancelled(canceller)
        self._tell_motion()
        self._waker.wake()

    @property
    def motion(self) -> RobotMotion:
        """The giver that drives the robot, and the robot's motion."""
        with self._lock:
            return self._dispatcher.records.motion

    def _tell_motion(self) -> None:
        """Calls `on_motion` if the motion has changed."""
        if self._on_motion:
            with self._telling:
                motion = self.motion
                if motion != self._told_motion:
                    self._told_motion = motion
                    self._call(self._on_motion, motion)

    # --- the thread of the client ----------------------------------------------------------------

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                cause = self._converse()
            except Exception as error:  # without this the thread would end and never reconnect
                cause = self._cause(error)
            self._lost(cause)
            self._closing.wait(self._backoff.after(cause))

    def _converse(self) -> LinkError:
        """Serves one connection from beginning to end; returns or raises why it ended."""
        self._answered.clear()
        self._set_link(LinkPhase.CONNECTING, self.peer, 'connecting')
        try:
            connection = ArclConnection.open(*self._address, CONNECT_TIMEOUT, self._closing.is_set)
        except OSError as error:
            return ConnectionFailed(f'cannot connect: {reason_of(error)}')
        self._set_link(LinkPhase.LOGGING_IN, self.peer, 'logging in')
        with connection, selectors.DefaultSelector() as selector:
            selector.register(connection.socket, selectors.EVENT_READ)
            selector.register(self._waker.reader, selectors.EVENT_READ)
            self._trace = self._log.connection() if self._log else None
            session = Session(self._password, trace=self._trace)
            self._log_in(connection, session, selector)
            return self._talk(LivePeer(connection, session, self._timeout), selector)

    def _log_in(self, connection: ArclConnection, session: Session,
                selector: selectors.BaseSelector) -> None:
        """Runs until the session is ready; raises LinkError or OSError."""
        peer = LivePeer(connection, session, max(self._timeout, LOGIN_SILENCE))
        began = time.monotonic()
        while session.state is not SessionState.READY and not self._closing.is_set():
            now = self._turn(peer, selector)
            if now - began > LOGIN_TIMEOUT:
                words = f'; the robot said "{session.words}"' if session.words else ''
                raise ConnectionFailed(f'the login took more than {LOGIN_TIMEOUT:.0f} s{words}')

    def _talk(self, peer: LivePeer, selector: selectors.BaseSelector) -> LinkError:
        while not self._closing.is_set():
            now = self._turn(peer, selector)
            with self._lock:
                self._dispatcher.on_time(now)
                in_doubt = self._dispatcher.in_doubt
            self._beat(now, min(self._heartbeat, _IN_DOUBT) if in_doubt else self._heartbeat)
            self._call_back()
        return ConnectionLost('closed by us')

    def _turn(self, peer: LivePeer, selector: selectors.BaseSelector) -> float:
        """Sends pending data, waits for an event, processes what came; returns the time then."""
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
        peer.connection.send(peer.session.take_output())
        while not peer.connection.unsent and peer.session.state is SessionState.READY:
            with self._lock:
                line = self._dispatcher.next_to_send(time.monotonic())
            if line is None:
                return
            if self._trace:
                self._trace('C', redact_passwords(line))
            peer.connection.send(line + b'\n')

    def _handle(self, event: Union[LoggedIn, Received], now: float) -> None:
        if isinstance(event, Received):
            self._learn_name(event)
            self._call(self._on_line, event)
            with self._lock:
                self._dispatcher.on_reply(event.reply, event.text, now)
        else:
            self._backoff.reset()
            with self._lock:
                self.help = event.help
                self._dispatcher.on_connected(now)
            # The first status shows what happened meanwhile, and whether to send an owed stop.
            self._pulsed_at = -math.inf
            self._set_link(LinkPhase.CONNECTED, self.peer)
            self._answered.set()
            self._call(self._on_login, event.help)

    def _learn_name(self, line: Received) -> None:
        """Remembers how the robot writes a name that is not ASCII."""
        if isinstance(line.reply, (Goal, Route, Macro)):
            if not line.raw.isascii():
                name = line.reply.name
                written = name.encode('utf-8')
                if written not in line.raw:
                    written = name.encode('latin-1')
                with self._lock:
                    if len(self._names) < _MAXIMUM_NAMES:
                        self._names[name] = written
        elif isinstance(line.reply, MapChanged):
            with self._lock:
                self._names.clear()

    def _beat(self, now: float, period: float) -> None:
        """Requests a sign of life when the period is over and no request is open."""
        if self._pulse is not None and self._pulse.result is not None:
            if self._pulse.result.outcome is Outcome.UNKNOWN_COMMAND:
                self._heartbeats.append(self._heartbeats.pop(0))
            self._pulse = None
        if self._pulse is None and now - self._pulsed_at >= period:
            self._pulsed_at = now
            with contextlib.suppress(Busy):  # answers to what is queued show that the robot lives
                self._pulse = self.execute(self._heartbeats[0])

    def _lost(self, cause: LinkError) -> None:
        refused = isinstance(cause, WrongPassword)
        if not refused:
            self._answered.clear()
        self._set_link(LinkPhase.WRONG_PASSWORD if refused else LinkPhase.DISCONNECTED, self.peer,
                       str(cause))
        if refused:
            self._answered.set()
        with self._lock:
            self._names.clear()
            self._dispatcher.on_lost(str(cause))
        self._pulse = None
        self._call_back()

    def _call_back(self) -> None:
        """Reports the outcomes to the givers of commands."""
        self._tell_motion()
        with self._lock:
            callbacks = self._dispatcher.pop_callbacks()
        for callback in callbacks:
            self._call(callback)
