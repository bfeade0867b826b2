"""The connection to the robot's ARCL server: log in, stay logged in, carry commands.

One thread owns the socket. It tells what comes through callbacks, which it calls itself, without
locks held: they may give commands, and must be short.
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
from omron_arcl.connection import Connection, Peer, reason_of
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.errors import (
    Busy,
    ConnectionFailed,
    ConnectionLost,
    LinkError,
    NotConnected,
    WrongPassword,
)
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome, Result
from omron_arcl.help_list import HelpList
from omron_arcl.link import Backoff, Link, LinkPhase
from omron_arcl.motion_authority import Motion, MotionAuthority
from omron_arcl.replies.site import Goal, Macro, MapChanged, Route
from omron_arcl.secret import redact_passwords
from omron_arcl.session import LoggedIn, Received, Session, State, Trace
from omron_arcl.session_log import SessionLog
from omron_arcl.transport import Transport

CONNECT_TIMEOUT = 3.0  # s, for each address of the robot
LOGIN_TIMEOUT = 15.0  # s from the connection to the end of the login
LOGIN_SILENCE = 4.0  # s without a word in the login after which it has failed, at least
HEARTBEATS = ('oneLineStatus', 'status')  # the second for robots that do not have the first
_IN_DOUBT = 1.0  # s between heartbeats while a status would tell whether a drive is over
_MAXIMUM_NAMES = 10_000


class Client(Transport):
    """A robot's ARCL server, connected to for ever until `close`.

    on_line(Received): a line came after the login. on_link(Link): the link changed.
    on_login(HelpList): logged in, once per connection. log: takes all that both sides say.
    heartbeat: seconds between signs of life asked of the robot; timeout: seconds without any, after
    which the link counts as dead. `names` is how the robot writes the names that it has listed and
    that are not ASCII. authority: knows the driver of the robot.
    on_motion(Motion): that has changed; called by any thread.
    """

    def __init__(self, host: str, port: int, password: bytes, *,
                 on_line: Optional[Callable[[Received], None]] = None,
                 on_link: Optional[Callable[[Link], None]] = None,
                 on_login: Optional[Callable[[HelpList], None]] = None,
                 log: Optional[SessionLog] = None, backoff: Optional[Backoff] = None,
                 heartbeat: float = 1.5, timeout: float = 4.0,
                 authority: Optional[MotionAuthority] = None,
                 on_motion: Optional[Callable[[Motion], None]] = None) -> None:
        self.peer = f'{host}:{port}'
        super().__init__('ARCL client', Link(LinkPhase.DISCONNECTED, self.peer, 'not started'),
                         on_link)
        self._address = (host, port)
        self._password = password
        self._on_line = on_line
        self._on_login = on_login
        self._on_motion = on_motion
        self._told_motion: Optional[Motion] = None
        self._telling = threading.Lock()  # motions are told in order
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
        self._dispatcher = Dispatcher(authority)
        self._answered = threading.Event()  # the password was taken, or refused

    # --- for any thread --------------------------------------------------------------------------

    def wait_connected(self, timeout: float) -> Link:
        """Waits until logged in or refused, `timeout` s at most; the link then."""
        self._answered.wait(timeout)
        return self.link

    @property
    def names(self) -> Mapping[str, bytes]:
        """The names that the robot has listed and that are not ASCII, as it writes them."""
        with self._lock:
            return dict(self._names)

    def execute(self, text: str, *, timeout: Optional[float] = None,
                on_line: Optional[Callable[[str], None]] = None,
                on_end: Optional[Callable[[Result], None]] = None,
                check: Optional[Callable[[Command], None]] = None,
                stop_on_timeout: bool = False, giver: Giver = NO_GIVER,
                known_epoch: int = 0) -> Execution:
        """Gives a command, e.g. `goto 12`. Raises InvalidCommand, NotConnected, Busy, Overruled or
        Unclear. A stop without a link is owed, and sent as soon as there is one.

        timeout: seconds without a word about it after which it counts as timed out, else the
        command's own. on_line, on_end: called by the client's thread. check: called with the
        command before it is sent; raises ArclError where it must not be. stop_on_timeout: a drive
        that has timed out is stopped. known_epoch: the one in which `giver` gives the command; 0 is
        for people, whose word counts in any.
        """
        with self._lock:
            command = parse_command(text, self.help.full_name, self._names)
        if check:
            check(command)
        try:
            with self._lock:
                link = self.link
                if not link.connected:
                    self._dispatcher.start_without_link(command, giver, known_epoch)
                    raise NotConnected(link.reason or link.phase.value)
                execution = self._dispatcher.start(command, timeout, on_line, on_end,
                                                   stop_on_timeout, giver, known_epoch)
        finally:
            self._tell_motion()
        self._waker.wake()
        return execution

    def cancel(self, execution: Execution, canceller: Giver = NO_GIVER) -> None:
        """Ends a command; a driving one by stopping the robot. Its result tells when it is over."""
        with self._lock:
            self._dispatcher.cancel(execution, time.monotonic(), canceller)
        self._tell_motion()
        self._waker.wake()

    def cancel_all(self, canceller: Giver) -> None:
        """A giver wants nothing of what was given before, be anything under way or not."""
        with self._lock:
            self._dispatcher.authority.take_word(canceller, time.monotonic())
        self._tell_motion()
        self._waker.wake()

    @property
    def motion(self) -> Motion:
        """The driver of the robot, and its motion."""
        with self._lock:
            return self._dispatcher.authority.motion

    def _tell_motion(self) -> None:
        """Tells the driver of the robot, where that has changed."""
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
            except Exception as error:  # a thread that died of it could never connect again
                cause = self._cause(error)
            self._lost(cause)
            self._closing.wait(self._backoff.after(cause))

    def _converse(self) -> LinkError:
        """One connection from beginning to end; returns or raises why it ended."""
        self._answered.clear()
        self._set_link(LinkPhase.CONNECTING, self.peer, 'connecting')
        try:
            connection = Connection.open(*self._address, CONNECT_TIMEOUT, self._closing.is_set)
        except OSError as error:
            return ConnectionFailed(f'cannot connect: {reason_of(error)}')
        self._set_link(LinkPhase.LOGGING_IN, self.peer, 'logging in')
        with connection, selectors.DefaultSelector() as selector:
            selector.register(connection.socket, selectors.EVENT_READ)
            selector.register(self._waker.reader, selectors.EVENT_READ)
            self._trace = self._log.connection() if self._log else None
            session = Session(self._password, trace=self._trace)
            self._log_in(connection, session, selector)
            return self._talk(Peer(connection, session, self._timeout), selector)

    def _log_in(self, connection: Connection, session: Session,
                selector: selectors.BaseSelector) -> None:
        """Until the session is ready; raises LinkError or OSError."""
        peer = Peer(connection, session, max(self._timeout, LOGIN_SILENCE))
        began = time.monotonic()
        while session.state is not State.READY and not self._closing.is_set():
            now = self._turn(peer, selector)
            if now - began > LOGIN_TIMEOUT:
                words = f'; the robot said "{session.words}"' if session.words else ''
                raise ConnectionFailed(f'the login took more than {LOGIN_TIMEOUT:.0f} s{words}')

    def _talk(self, peer: Peer, selector: selectors.BaseSelector) -> LinkError:
        while not self._closing.is_set():
            now = self._turn(peer, selector)
            with self._lock:
                self._dispatcher.on_time(now)
                in_doubt = self._dispatcher.in_doubt
            self._beat(now, min(self._heartbeat, _IN_DOUBT) if in_doubt else self._heartbeat)
            self._call_back()
        return ConnectionLost('closed by us')

    def _turn(self, peer: Peer, selector: selectors.BaseSelector) -> float:
        """Sends what is due, waits for something to do, reads what came; the time then."""
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

    def _send(self, peer: Peer) -> None:
        """Sends what is due; one command at a time, so that a stop passes all others."""
        peer.connection.send(peer.session.take_output())
        while not peer.connection.unsent and peer.session.state is State.READY:
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
            # A status tells whether a stop that is owed is still wanted.
            self._pulsed_at = -math.inf if self.motion.memory.stop_owed else now
            self._set_link(LinkPhase.CONNECTED, self.peer)
            self._answered.set()
            self._call(self._on_login, event.help)

    def _learn_name(self, line: Received) -> None:
        """Remembers how the robot writes a name, where that is a question."""
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
        """Asks for a sign of life when it is time and none is awaited."""
        if self._pulse is not None and self._pulse.result is not None:
            if self._pulse.result.outcome is Outcome.UNKNOWN_COMMAND:
                self._heartbeats.append(self._heartbeats.pop(0))
            self._pulse = None
        if self._pulse is None and now - self._pulsed_at >= period:
            self._pulsed_at = now
            with contextlib.suppress(Busy):  # with so much to say there are signs of life enough
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
        """Tells the givers of commands their outcomes."""
        self._tell_motion()
        with self._lock:
            callbacks = self._dispatcher.pop_callbacks()
        for callback in callbacks:
            self._call(callback)
