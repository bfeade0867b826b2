"""One connection as a state machine without I/O: bytes in, events out.

There are two kinds. On port 7171 the robot asks for a password and lists its commands first; the
connection that the robot opens itself (7179) speaks at once. In both, `read` takes what came from
the socket and gives what it means, and `take_output` gives what is to be sent for the session's own
part: the password, and `echo off`.
"""
from __future__ import annotations

import re
from enum import Enum
from typing import Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional, Tuple, Type, Union

from omron_arcl.errors import (
    ConnectionFailed,
    ConnectionLost,
    LineTooLong,
    LinkError,
    WrongPassword,
)
from omron_arcl.framing import LONGEST_LINE, LineBuffer
from omron_arcl.parser import parse_line
from omron_arcl.replies.configuration import ConfigValue
from omron_arcl.replies.general import Done, HelpEntry, Item, ServerClosing
from omron_arcl.replies.refusals import CommandError
from omron_arcl.replies.reply import Reply, UnknownLine
from omron_arcl.secret import BLANKED, blank_configured


class State(Enum):
    """Where a session is."""

    AWAITING_PROMPT = 'awaiting the prompt'
    LOGGING_IN = 'logging in'
    DRAINING_HELP_LIST = 'reading the help list'
    READY = 'ready'
    CLOSED = 'closed'


# The login: which line takes a state to the next. Source: the login of a real LD-90.
_LOGIN: Dict[State, Tuple[bytes, State]] = {
    State.AWAITING_PROMPT: (b'enter password:', State.LOGGING_IN),
    State.LOGGING_IN: (b'welcome to the server.', State.DRAINING_HELP_LIST),
    State.DRAINING_HELP_LIST: (b'end of commands', State.READY),
}

# What it means when the peer closes the connection: after a wrong password it does so at once.
_CLOSED_WHILE: Dict[State, Tuple[Type[LinkError], str]] = {
    State.AWAITING_PROMPT: (ConnectionFailed, 'the robot closed the connection before the login'),
    State.LOGGING_IN: (WrongPassword, 'the robot refused the password'),
    State.DRAINING_HELP_LIST: (ConnectionLost, 'the robot closed the connection in the login'),
    State.READY: (ConnectionLost, 'the robot closed the connection'),
}

_LONGEST_HELP_LIST = 2000
_MAY_HOLD_PASSWORD = (ConfigValue, Done, CommandError, UnknownLine)  # an echoed line is unknown
_SHORTCUT = re.compile(r'\[(\w+)\]\s*$')


class HelpList:
    """The commands that the robot has, by its own help list; names are compared without case."""

    def __init__(self, descriptions: Mapping[str, str]) -> None:
        self.descriptions = dict(descriptions)
        self._names = {name.lower(): name for name in descriptions}
        for name, description in descriptions.items():
            shortcut = _SHORTCUT.search(description)
            if shortcut:
                self._names.setdefault(shortcut.group(1).lower(), name)

    def full_name(self, name: str) -> Optional[str]:
        """The command that `name`, or the shortcut `name`, stands for; None if there is none."""
        return self._names.get(name.lower())

    def __len__(self) -> int:
        return len(self.descriptions)


class LoggedIn(NamedTuple):
    """The session is ready for commands."""

    help: HelpList


class Received(NamedTuple):
    """A line of the robot: exactly as received, and what it means."""

    raw: bytes
    reply: Reply

    @property
    def text(self) -> str:
        """The line for people; what is no UTF-8 is replaced."""
        return self.raw.decode('utf-8', 'replace')


class Closed(NamedTuple):
    """The session is over, always the last event."""

    cause: LinkError


Event = Union[LoggedIn, Received, Closed]
Trace = Callable[[str, bytes], None]  # side, 'C' (client) or 'S' (server), and a line; no secrets


class Session:
    """The client's end of one connection; with `password` None the kind without login."""

    def __init__(self, password: Optional[bytes], longest_line: int = LONGEST_LINE,
                 trace: Optional[Trace] = None) -> None:
        self.state = State.READY if password is None else State.AWAITING_PROMPT
        self._password = password
        self._trace = trace
        self._lines = LineBuffer(longest_line)
        self._output = bytearray()
        self._help: Dict[str, str] = {}
        self._last_words = ''

    def read(self, data: bytes) -> Iterator[Event]:
        """What `data` from the socket means, event by event; to be read to its end.

        One line is read when the one before it has been dealt with, so that it need not wait for
        those behind it.
        """
        for raw in self._lines.feed(data):
            if self.state is State.READY:
                yield self._received(raw)
            elif self.state is not State.CLOSED:
                yield from self._log_in(raw)
        if self._lines.overflowed and self.state is not State.CLOSED:
            yield self._close(LineTooLong(self._lines.limit))

    def receive(self, data: bytes) -> List[Event]:
        """All that `data` from the socket means."""
        return list(self.read(data))

    def receive_eof(self) -> List[Event]:
        """What it means that the peer closed the connection now."""
        if self.state is State.CLOSED:
            return []
        kind, reason = _CLOSED_WHILE[self.state]
        if self._last_words:
            reason += f', saying "{self._last_words}"'
        return [self._close(kind(reason))]

    def take_output(self) -> bytes:
        """What the session itself has to say to the robot; empties it."""
        output = bytes(self._output)
        self._output.clear()
        return output

    def _log_in(self, raw: bytes) -> Iterator[Event]:
        """A line of the login."""
        if self._trace:
            self._trace('S', raw.replace(self._password, BLANKED))
        said = raw.strip().lower()
        awaited, following = _LOGIN[self.state]
        if said == awaited:
            self.state = following
            self._last_words = ''
            if following is State.LOGGING_IN:
                self._say(self._password, BLANKED)
            elif following is State.READY:
                help_list = HelpList(self._help)
                if help_list.full_name('echo'):
                    self._say(b'echo off')
                yield LoggedIn(help_list)
        elif self.state is State.AWAITING_PROMPT:
            self._last_words = raw[:100].decode('ascii', 'replace')
        elif self.state is State.LOGGING_IN and said == _LOGIN[State.AWAITING_PROMPT][0]:
            kind, reason = _CLOSED_WHILE[State.LOGGING_IN]
            yield self._close(kind(reason))
        elif self.state is State.DRAINING_HELP_LIST:
            yield from self._read_help(raw)

    def _read_help(self, raw: bytes) -> Iterator[Event]:
        """An entry of the help list, or a line of another client's doings between two entries."""
        reply = parse_line(raw.decode('utf-8', 'replace'))
        if isinstance(reply, HelpEntry):
            self._help[reply.name] = reply.description
            if len(self._help) > _LONGEST_HELP_LIST:
                yield self._close(ConnectionFailed('the help list of the robot does not end'))
        elif not isinstance(reply, (UnknownLine, Item)):
            yield Received(raw, reply)

    def _received(self, raw: bytes) -> Received:
        reply = parse_line(raw.decode('utf-8', 'replace'))
        if type(reply) in _MAY_HOLD_PASSWORD:
            blanked = blank_configured(raw)
            if blanked != raw:
                raw, reply = blanked, parse_line(blanked.decode('utf-8', 'replace'))
        elif type(reply) is ServerClosing:
            self._last_words = reply.text
        if self._trace:
            self._trace('S', raw)
        return Received(raw, reply)

    def _say(self, line: bytes, shown: bytes = b'') -> None:
        self._output += line + b'\n'
        if self._trace:
            self._trace('C', shown or line)

    def _close(self, cause: LinkError) -> Closed:
        self.state = State.CLOSED
        return Closed(cause)
