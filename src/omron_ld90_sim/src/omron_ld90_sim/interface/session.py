"""One ARCL connection without I/O: it takes received bytes and keeps the bytes to send.

Framing, login and echo are those of a robot (docs/explanation/sources.md): lines end with CRLF, LF
or CR; after a wrong password the connection closes silently; a command of more than 5,000
characters drops the client.

    phase   event                                    next phase
    LOGIN   the right password                       OPEN; welcome and help list are sent
            another line                             CLOSED
    OPEN    a line                                   OPEN; it is carried out
    all     too long a line; the connection ends     CLOSED

Invariants: lines are sent in the order in which they were queued, even if some are delayed. No
command is carried out before the right password.
"""
from __future__ import annotations

import hmac
import re
from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import Deque, Optional, Protocol, Tuple

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.dialect import Dialect, HelpLayout

MAX_COMMAND = 5000
CYCLE = 0.1                 # s between two checks of the server for client input
HIDDEN = b'********'        # replaces the password in a log
BLANK = b' \t\0'           # removed at both ends of a line; telnet sends a NUL after a CR
_TELNET = re.compile(rb'^(?:\xff[\xfb-\xfe].|[\x80-\xff])+', re.DOTALL)


def said(line: bytes) -> bytes:
    """Returns a client's line without telnet negotiation and without the blanks around it."""
    return _TELNET.sub(b'', line).strip(BLANK)


class LoginPhase(Enum):
    """The phase of a session."""

    LOGIN = 'login'
    OPEN = 'open'
    CLOSED = 'closed'


@dataclass
class Impairment:
    """Impairments of the network, on demand (`faults`)."""

    delay: float = 0.0                  # s by which every line is late
    silent_until: float = 0.0           # time before which nothing is sent
    half_line: Optional[float] = None   # s by which the second half of the next line is late


class SessionHost(Protocol):
    """What a session requires of its server."""

    clock: SimClock
    password: str
    impairment: Impairment
    dialect: Dialect

    def log(self, number: int, direction: str, line: bytes) -> None:
        """Logs a line with its connection and its sender: `C` (client) or `S` (server)."""

    def execute(self, session: SimSession, line: str) -> None:
        """Executes a command line."""

    def forget(self, session: SimSession) -> None:
        """Removes a session that has ended."""


class SimSession:
    """One connection of a client, or the robot's own outgoing one.

    Its attributes are the state of this connection.
    """

    def __init__(self, server: SessionHost, number: int, outgoing: bool = False) -> None:
        self.server, self.number, self.outgoing = server, number, outgoing
        self.output = bytearray()
        self.echo: Optional[bool] = None        # None until it is set: see _echo_typed
        self.task_list: Optional[list] = None   # the list that listAdd extends
        self.aborted = False            # ended with RST, so that queued lines are lost
        self.phase = LoginPhase.OPEN if outgoing else LoginPhase.LOGIN
        self.last_received = server.clock.now
        self._input = b''               # an incomplete line
        self._echoed = 0                # number of bytes of _input that were echoed
        self._held: Deque[Tuple[float, bytes]] = deque()
        if not outgoing:
            self.server.log(number, 'S', server.dialect.prompt.rstrip(b'\r\n'))
            self._put(server.dialect.prompt)

    @property
    def closed(self) -> bool:
        """Whether the session has ended; queued bytes are still sent."""
        return self.phase is LoginPhase.CLOSED

    @property
    def finished(self) -> bool:
        """Whether it is closed and everything has been sent."""
        return self.closed and not self.output and not self._held

    def send(self, line: str) -> None:
        """Queues one line."""
        if self.closed:
            return
        data = self.server.dialect.encoding.encode(line)
        self.server.log(self.number, 'S', data)
        data += b'\r\n'
        fault = self.server.impairment
        if fault.half_line is not None and self.phase is LoginPhase.OPEN:
            half, rest, fault.half_line = len(data) // 2, fault.half_line, None
            self._put(data[:half])
            self._put(data[half:], rest)
        else:
            self._put(data)

    def _put(self, data: bytes, later: float = 0.0) -> None:
        fault, now = self.server.impairment, self.server.clock.now
        before = self._held[-1][0] if self._held else now
        due = max(now + fault.delay, fault.silent_until, before) + later
        if due <= now and not self._held:
            self.output += data
        else:
            self._held.append((due, data))
            self.server.clock.at(due, self._release)

    def _release(self) -> None:
        while self._held and self._held[0][0] <= self.server.clock.now:
            self.output += self._held.popleft()[1]

    def close(self, abort: bool = False) -> None:
        """Ends the session after the queue has been sent; with `abort`, at once."""
        self.aborted = abort
        if abort:
            self.output.clear()
            self._held.clear()
        self.phase = LoginPhase.CLOSED
        self.server.forget(self)

    def receive(self, data: bytes) -> None:
        """Receives bytes from the client, in pieces of any size."""
        self.last_received = self.server.clock.now
        *lines, self._input = (self._input + data.replace(b'\r', b'\n')).split(b'\n')
        for line in lines:
            if self._echoed:
                self._put(b'\n\r')
                self._echoed = 0
            if self._accepts(line):
                self._line_received(said(line))
        if self._accepts(self._input) and self._input:
            self.server.clock.after(CYCLE, self._echo_typed)

    def _accepts(self, line: bytes) -> bool:
        """Returns whether to process a line; drops a client whose line is too long."""
        if len(line) > MAX_COMMAND:
            self.send('String too long')
            self.close()
        if line >= b'\x80' and self.echo is None:
            self.echo = False       # telnet negotiation: this client shows typed text itself
        return not self.closed

    def _echo_typed(self) -> None:
        """Echoes the incomplete line, as the server does until `echo` is set."""
        if self.echo is None and not self.closed:
            typed = self._input[self._echoed:].decode('ascii', 'ignore')
            self._put(typed.encode('ascii'))
            self._echoed = len(self._input)

    def _line_received(self, line: bytes) -> None:
        if not line:
            return
        if self.phase is LoginPhase.LOGIN:
            self.server.log(self.number, 'C', HIDDEN)
            self._log_in(line)
        else:
            self.server.log(self.number, 'C', line)
            text = self.server.dialect.encoding.decode(line)
            if self.echo:
                self.send(text)
            self.server.execute(self, text)

    def _log_in(self, password: bytes) -> None:
        if not hmac.compare_digest(password, self.server.password.encode()):
            self.close()
            return
        self.phase = LoginPhase.OPEN
        for line in self.server.dialect.welcome:
            self.send(line)
        if self.server.dialect.help_layout is not HelpLayout.NONE:
            self.server.execute(self, 'help')
