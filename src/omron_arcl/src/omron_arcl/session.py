"""One connection as a state machine without I/O: takes bytes and time, returns events.

There are two kinds of connection. On port 7171 the robot first asks for a password and lists its
commands. The robot itself opens the other connection (port 7179), and sends lines on it at once.
For both kinds, `read` takes the bytes of the socket and returns their meaning. `on_time` tells the
session the time, which it needs during the login. `pop_output` returns the lines that the session
itself sends: the password and `echo off`.

The login of a real LD-90 consists of a prompt on a separate line, `Welcome to the server.` and a
help list with an end line. After a wrong password the robot closes the connection without a
message. Other robots differ, so these rules apply:
- Each line that asks for a password is a prompt.
- A line after the password that neither asks again nor complains is a welcome.
- If an expected line does not come, the login goes on without it.

    state               event                                             next state
    AWAITING_PROMPT     a line that asks; PROMPT_TIMEOUT                  LOGGING_IN, password sent
    LOGGING_IN          a line that complains, or that asks once more     CLOSED
                        another line, but not the echo of the password    DRAINING_HELP_LIST
    DRAINING_HELP_LIST  its end line; HELP_TIMEOUT; LONGEST_HELP          READY, `LoggedIn`
                        more than _MAXIMUM_ENTRIES entries                CLOSED
    all                 end of the connection; a line that is too long;   CLOSED, `Closed`
                        a web browser

Invariants: `Closed` is the last event. The password is sent once, and is in no event, reason or
trace. After `LoggedIn`, each line is one `Received`.
"""
from __future__ import annotations

import re
from enum import Enum
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Union

from browser_guard import is_http_request
from omron_arcl.command_line import printable
from omron_arcl.errors import (
    ConnectionFailed,
    ConnectionLost,
    LineTooLong,
    LinkError,
    WrongPassword,
)
from omron_arcl.framing import LONGEST_LINE, LineBuffer, decode
from omron_arcl.help_list import HelpList, read_entry
from omron_arcl.parser import parse_line
from omron_arcl.replies import (
    CommandError,
    ConfigValue,
    Done,
    HelpEntry,
    Item,
    Reply,
    ServerClosing,
    UnknownLine,
)
from omron_arcl.secret import REDACTED, redact_passwords

PROMPT_TIMEOUT = 1.0  # s of silence after which the password is sent without a prompt
WELCOME_TIMEOUT = 1.0  # s of silence after the password until a status is requested
HELP_TIMEOUT = 1.5  # s of silence in the help list after which the list counts as read
LONGEST_HELP = 10.0  # s from the welcome until the help list counts as read at the latest
_PROBE = b'oneLineStatus'
_MAXIMUM_ENTRIES = 2000
_MAXIMUM_WORDS = 150  # largest number of the robot's characters that the reason of a failure quotes

_ASKS = re.compile(rb'passw', re.IGNORECASE)
_COMPLAINS = re.compile(
    rb'\b(wrong|incorrect|invalid|denied|refused|fail(ed|ure)?|unauthori[sz]ed|bad|not allowed)\b',
    re.IGNORECASE)
_PROMPT_ENDS = (b':', b'>', b'?')
# A sent line that the robot echoes is read as an UnknownLine.
_MAY_HOLD_PASSWORD = (ConfigValue, Done, CommandError, UnknownLine)


class SessionState(Enum):
    """The state of a session."""

    AWAITING_PROMPT = 'awaiting the prompt'
    LOGGING_IN = 'logging in'
    DRAINING_HELP_LIST = 'reading the help list'
    READY = 'ready'
    CLOSED = 'closed'


_BEFORE_THE_WELCOME = (SessionState.AWAITING_PROMPT, SessionState.LOGGING_IN)


class LoggedIn(NamedTuple):
    """The session is ready for commands."""

    help: HelpList


class Received(NamedTuple):
    """A line of the robot.

    raw -- the line exactly as it was received; passwords are redacted
    reply -- its meaning
    late -- the line may be old: it may have waited while this process was suspended, or while the
        network stalled
    """

    raw: bytes
    reply: Reply
    late: bool = False

    @property
    def text(self) -> str:
        """The line as text, see `framing.decode`."""
        return decode(self.raw)


class Closed(NamedTuple):
    """The session is over; always the last event."""

    cause: LinkError


Event = Union[LoggedIn, Received, Closed]
# Called with the sender, 'C' (client) or 'S' (server), and the line that it sent, without secrets.
Trace = Callable[[str, bytes], None]


class Session:
    """The client's end of one connection. If `password` is None, the connection has no login.

    `lines_read` is the number of complete lines received. Only a complete line is a sign of life of
    the robot. The other attributes are mainly the state of the login.
    """

    def __init__(self, password: Optional[bytes], longest_line: int = LONGEST_LINE,
                 trace: Optional[Trace] = None) -> None:
        self.state = SessionState.READY if password is None else SessionState.AWAITING_PROMPT
        self.lines_read = 0
        self._password = password or b''
        self._trace = trace
        self._lines = LineBuffer(longest_line)
        self._output = bytearray()
        self._help: Dict[str, str] = {}
        self._help_begun = False
        self._prompted = False
        self._probed = False
        self._said: List[str] = []  # the robot's last lines
        self._stirred = True  # something came since the last `on_time`
        self._quiet_since = 0.0
        self._welcomed_at: Optional[float] = None

    @property
    def words(self) -> str:
        """The robot's words in the login so far; the reason of a failure quotes them."""
        said = ' / '.join(self._said)
        if self._lines.tail:
            said = f'{said} / {self._shown(self._lines.tail)}'.lstrip(' /')
        return printable(said, _MAXIMUM_WORDS)

    def read(self, data: bytes) -> Iterator[Event]:
        """Yields the events in `data` from the socket, one by one; the caller must read all.

        A line is read only when the caller has processed the line before it. So a line need not
        wait until the lines behind it are read.
        """
        self._stirred = True
        for raw in self._lines.feed(data):
            self.lines_read += 1
            if self.lines_read == 1 and is_http_request(raw):
                yield self._close(ConnectionFailed('a web browser has connected, not a robot'))
            elif self.state is SessionState.READY:
                yield self._received(raw)
            elif self.state is not SessionState.CLOSED:
                yield from self._log_in(raw)
        if self.state in _BEFORE_THE_WELCOME and self._asks_in_the_tail():
            self.lines_read += 1
            yield from self._log_in(self._lines.pop_tail())
        if self._lines.overflowed and self.state is not SessionState.CLOSED:
            yield self._close(LineTooLong(self._lines.limit))

    def receive(self, data: bytes) -> List[Event]:
        """Returns all events in `data` from the socket."""
        return list(self.read(data))

    def receive_eof(self) -> List[Event]:
        """Notes that the peer has closed the connection; returns the events."""
        if self.state is SessionState.CLOSED:
            return []
        return [self._close(self._cause_of_eof())]

    def on_time(self, now: float) -> List[Event]:
        """Notes the time `now` (s, any clock). In the login, stops waiting for overdue lines."""
        if self.state in (SessionState.READY, SessionState.CLOSED):
            return []
        if self._stirred:
            self._stirred, self._quiet_since = False, now
        quiet = now - self._quiet_since
        if self.state is SessionState.AWAITING_PROMPT and quiet >= PROMPT_TIMEOUT:
            self._send_password()
        elif self.state is SessionState.LOGGING_IN:
            if quiet >= WELCOME_TIMEOUT and not self._probed:
                self._probed = True
                self._say(_PROBE)
        elif self.state is SessionState.DRAINING_HELP_LIST:
            if self._welcomed_at is None:
                self._welcomed_at = now
            if quiet >= HELP_TIMEOUT or now - self._welcomed_at >= LONGEST_HELP:
                return [self._ready(complete=False)]
        return []

    def pop_output(self) -> bytes:
        """Returns and clears the bytes that the session itself sends to the robot."""
        output = bytes(self._output)
        self._output.clear()
        return output

    # --- the login --------------------------------------------------------------------------------

    def _asks_in_the_tail(self) -> bool:
        """Returns whether the unfinished line is a prompt: a prompt may have no line end."""
        tail = self._lines.tail.rstrip()
        return bool(tail) and tail.endswith(_PROMPT_ENDS) and bool(_ASKS.search(tail))

    def _log_in(self, raw: bytes) -> Iterator[Event]:
        """Processes a line of the login."""
        if self._trace:
            self._trace('S', self._redacted(raw))
        if self.state is SessionState.AWAITING_PROMPT:
            if _ASKS.search(raw):
                self._prompted = True
                self._send_password()
            else:
                self._remember(raw)
        elif self.state is SessionState.LOGGING_IN:
            yield from self._read_verdict(raw)
        else:
            yield from self._read_help(raw)

    def _send_password(self) -> None:
        self.state = SessionState.LOGGING_IN
        self._stirred = True
        self._say(self._password, REDACTED)

    def _read_verdict(self, raw: bytes) -> Iterator[Event]:
        """Processes the first line after the password and its echo."""
        if raw.strip() == self._password:
            return
        self._remember(raw)
        if _COMPLAINS.search(raw):
            yield self._close(WrongPassword(f'the robot refused the password{self._quoted()}'))
        elif _ASKS.search(raw):
            if self._prompted:
                yield self._close(WrongPassword('the robot refused the password, and asked again'))
            self._prompted = self._probed = True  # a late prompt: the password was sent
        else:
            self.state = SessionState.DRAINING_HELP_LIST
            yield from self._read_help(raw)

    def _read_help(self, raw: bytes) -> Iterator[Event]:
        """Processes an entry of the help list; lines about other clients may come in between."""
        text = decode(raw)
        heading = text.strip().lower()
        if heading in ('commands:', 'end of commands'):
            self._help_begun = True
            if heading == 'end of commands':
                yield self._ready(complete=True)
            return
        reply = parse_line(text)
        if isinstance(reply, HelpEntry):
            self._help[reply.name] = reply.description
        elif not isinstance(reply, (UnknownLine, Item)):
            yield self._received(raw, traced=True)
        elif self._help_begun:
            entry = read_entry(text)
            if entry:
                self._help[entry[0]] = entry[1]
        if len(self._help) > _MAXIMUM_ENTRIES:
            yield self._close(ConnectionFailed('the help list of the robot does not end'))

    def _ready(self, complete: bool) -> LoggedIn:
        self.state = SessionState.READY
        self._said.clear()
        help_list = HelpList(self._help, complete)
        if help_list.full_name('echo') or not complete:
            self._say(b'echo off')
        return LoggedIn(help_list)

    # --- after the login --------------------------------------------------------------------------

    def _received(self, raw: bytes, traced: bool = False) -> Received:
        reply = parse_line(decode(raw))
        if type(reply) in _MAY_HOLD_PASSWORD:
            redacted = redact_passwords(raw)
            if redacted != raw:
                raw, reply = redacted, parse_line(decode(redacted))
        elif type(reply) is ServerClosing:
            self._remember(raw)
        if self._trace and not traced:
            self._trace('S', raw)
        return Received(raw, reply)

    def _say(self, line: bytes, shown: bytes = b'') -> None:
        self._output += line + b'\n'
        if self._trace:
            self._trace('C', shown or line)

    def _close(self, cause: LinkError) -> Closed:
        self.state = SessionState.CLOSED
        return Closed(cause)

    def _cause_of_eof(self) -> LinkError:
        if self.state is SessionState.AWAITING_PROMPT:
            return ConnectionFailed('the robot closed the connection before the login'
                                    + self._quoted())
        if self.state is SessionState.LOGGING_IN and self._prompted:
            return WrongPassword(f'the robot refused the password{self._quoted()}')
        if self.state is SessionState.LOGGING_IN:
            return ConnectionFailed('the robot closed the connection after the password, which '
                                    f'it had not asked for{self._quoted()}')
        if self.state is SessionState.DRAINING_HELP_LIST:
            return ConnectionLost('the robot closed the connection during the login')
        return ConnectionLost(f'the robot closed the connection{self._quoted()}')

    def _quoted(self) -> str:
        return f', saying "{self.words}"' if self.words else ''

    def _remember(self, raw: bytes) -> None:
        """Keeps the robot's last lines, which the reason of a failure quotes."""
        self._said = [*self._said, self._shown(raw)][-5:]

    def _shown(self, raw: bytes) -> str:
        return decode(self._redacted(raw)[:_MAXIMUM_WORDS]).strip()

    def _redacted(self, raw: bytes) -> bytes:
        return raw.replace(self._password, REDACTED) if self._password else raw
