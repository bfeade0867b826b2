"""The connection to a robot's ARCL server: sends commands, and reports how they end.

The link's thread calls the callbacks that report lines and results. Meanwhile it holds no lock, so
a callback may give commands. A callback must be short.
"""
from __future__ import annotations

import contextlib
import math
import threading
import time
from typing import Callable, Dict, Mapping, Optional

from omron_arcl.arcl_link import ArclLink
from omron_arcl.command_line import parse_command
from omron_arcl.commands import Command
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.drives import Drives
from omron_arcl.errors import Busy, LinkError, NotConnected, StopOwed
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome, Result
from omron_arcl.help_list import HelpList
from omron_arcl.link import Backoff, Link, LinkPhase
from omron_arcl.records import RobotMotion
from omron_arcl.replies import Goal, Macro, MapChanged, Route
from omron_arcl.session import LoggedIn, Received
from omron_arcl.session_log import SessionLog

HEARTBEATS = ('oneLineStatus', 'status')  # `status` is for robots without `oneLineStatus`
_IN_DOUBT = 1.0  # s between heartbeats while a status may decide whether a drive is over
_MAXIMUM_NAMES = 10_000


class Client(ArclLink):
    """The connection to a robot's ARCL server; connects again after each loss until `close`.

    on_line(Received): a line came after the login. on_link(Link): the link changed.
    on_login(HelpList): the login succeeded; called once per connection. log: records all lines of
    both sides. heartbeat: seconds between two requests for a sign of life. timeout: s; after a
    longer time without a sign of life, the link counts as dead. records: the records of the robot's
    drives. on_motion(RobotMotion): the motion has changed; called by any thread.

    The client is the user of its own link. It has many attributes because one thread keeps one
    connection with its parts, callbacks and times.
    """

    def __init__(self, host: str, port: int, password: bytes, *,
                 on_line: Optional[Callable[[Received], None]] = None,
                 on_link: Optional[Callable[[Link], None]] = None,
                 on_login: Optional[Callable[[HelpList], None]] = None,
                 log: Optional[SessionLog] = None, backoff: Optional[Backoff] = None,
                 heartbeat: float = 1.5, timeout: float = 4.0,
                 records: Optional[Drives] = None,
                 on_motion: Optional[Callable[[RobotMotion], None]] = None) -> None:
        super().__init__('ARCL client', host, port, password, self, silence=timeout,
                         on_link=on_link, log=log, backoff=backoff)
        self._on_line = on_line
        self._on_login = on_login
        self._on_motion = on_motion
        self._told_motion: Optional[RobotMotion] = None
        self._telling = threading.Lock()  # keeps the calls of on_motion in order
        self._heartbeat = heartbeat

        self.help = HelpList({}, complete=False)
        self._names: Dict[str, bytes] = {}
        self._pulse: Optional[Execution] = None
        self._pulsed_at = 0.0
        self._heartbeats = list(HEARTBEATS)
        self._lock = threading.Lock()  # guards help, _names, _dispatcher
        self._dispatcher = Dispatcher(records)
        self._answered = threading.Event()  # the robot has accepted or refused the password

    # --- for any thread --------------------------------------------------------------------------

    def wait_connected(self, timeout: float) -> Link:
        """Waits at most `timeout` s for the login or its refusal, and returns the link."""
        self._answered.wait(timeout)
        return self.link

    @property
    def names(self) -> Mapping[str, bytes]:
        """The listed names that are not ASCII, each with the robot's bytes for it."""
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

        timeout: the command times out after so many s without a line about it; None: the timeout of
        the kind of command. on_line, on_end: called by the client's thread. check: called with the
        command before it is sent; raises ArclError if the command must not be sent.
        stop_on_timeout: stops a drive that has timed out. known_epoch: the epoch that `giver`
        knows; 0 is for people, whose commands are valid in each epoch. number: the number that the
        giver gives the command (ascending); `motion` shows the fate of the giver's last command.
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
            self._publish_motion()
        self._waker.wake()
        return execution

    def cancel(self, execution: Execution, canceller: Giver = NO_GIVER) -> None:
        """Cancels a command, and stops the robot if it is a drive.

        `execution.result` is set when the command has ended.
        """
        with self._lock:
            self._dispatcher.cancel(execution, time.monotonic(), canceller)
        self._publish_motion()
        self._waker.wake()

    def cancel_all(self, canceller: Giver) -> None:
        """Cancels all earlier commands on behalf of `canceller`, even if none is under way."""
        with self._lock:
            self._dispatcher.records.all_cancelled(canceller)
        self._publish_motion()
        self._waker.wake()

    @property
    def motion(self) -> RobotMotion:
        """The giver that drives the robot, and the robot's motion."""
        with self._lock:
            return self._dispatcher.records.motion

    def _publish_motion(self) -> None:
        """Calls `on_motion` if the motion has changed."""
        if self._on_motion:
            with self._telling:
                motion = self.motion
                if motion != self._told_motion:
                    self._told_motion = motion
                    self._call(self._on_motion, motion)

    # --- the thread of the client ----------------------------------------------------------------

    def _set_link(self, phase: LinkPhase, peer: str, reason: str = '') -> None:
        is_answered = phase in (LinkPhase.CONNECTED, LinkPhase.WRONG_PASSWORD)
        if not is_answered:
            self._answered.clear()
        super()._set_link(phase, peer, reason)
        if is_answered:
            self._answered.set()
        if phase is LinkPhase.CONNECTED:
            self._call(self._on_login, self.help)

    def hear_login(self, login: LoggedIn, now: float) -> None:
        """Notes that the link is logged in."""
        with self._lock:
            self.help = login.help
            self._dispatcher.on_connected(now)
        # Requests a status at once: it shows what happened during the outage, and whether an owed
        # stop must be sent.
        self._pulsed_at = -math.inf

    def hear_line(self, line: Received, now: float) -> None:
        """Handles a line of the robot."""
        self._learn_name(line)
        self._call(self._on_line, line)
        with self._lock:
            self._dispatcher.on_reply(line.reply, line.text, now)

    def hear_turn(self, now: float) -> None:
        """Processes the passage of time, and requests a sign of life when it is due."""
        with self._lock:
            self._dispatcher.on_time(now)
            in_doubt = self._dispatcher.in_doubt
        self._beat(now, min(self._heartbeat, _IN_DOUBT) if in_doubt else self._heartbeat)
        self._call_back()

    def next_to_send(self, now: float) -> Optional[bytes]:
        """Returns the next command."""
        with self._lock:
            return self._dispatcher.next_to_send(now)

    def hear_loss(self, cause: LinkError) -> None:
        """Notes that the link has ended: the commands that were sent are lost."""
        with self._lock:
            self._names.clear()
            self._dispatcher.on_lost(str(cause))
        self._pulse = None
        self._call_back()

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
            with contextlib.suppress(Busy):  # the answers to queued commands are signs of life, too
                self._pulse = self.execute(self._heartbeats[0])

    def _call_back(self) -> None:
        """Reports the outcomes to the givers of commands."""
        self._publish_motion()
        with self._lock:
            callbacks = self._dispatcher.pop_callbacks()
        for callback in callbacks:
            self._call(callback)
