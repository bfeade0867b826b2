"""The ARCL server without I/O: sessions that take bytes and hold the bytes to send.

A `Session` is one connection. Replies go to the session that asked; `ArclServer.broadcast` goes to
every logged-in one, the outgoing link included. Framing and login are those of the facts: lines end
with CRLF, LF or CR, a wrong password closes without a word, a command over 5,000 characters drops
the client.
"""
from __future__ import annotations

import hmac
import re
from enum import Enum
from typing import Dict, List, Optional

from omron_ld90_sim.clock import Clock, Timer
from omron_ld90_sim.commands import TABLE, Call, CommandFailed, SetUpError, help_lines
from omron_ld90_sim.robot import Robot

MAX_COMMAND = 5000
UNKNOWN_NAME = 16           # characters of an unknown command's name in the answer
_TELNET = re.compile(rb'^(?:\xff[\xfb-\xfe].|[\x80-\xff])+', re.DOTALL)


class Phase(Enum):
    """How far a session is."""

    LOGIN = 'login'
    OPEN = 'open'
    CLOSED = 'closed'


class Session:
    """One connection of a client, or the robot's own outgoing one."""

    def __init__(self, server: ArclServer, number: int, outgoing: bool = False) -> None:
        self.server, self.number, self.outgoing = server, number, outgoing
        self.output = bytearray()
        self.echo = False
        self.phase = Phase.OPEN if outgoing else Phase.LOGIN
        self._input = bytearray()
        self.last_received = server.clock.now
        if not outgoing:
            self.send('Enter password:')

    @property
    def closed(self) -> bool:
        """Whether the connection ends once `output` has been sent."""
        return self.phase is Phase.CLOSED

    def send(self, line: str) -> None:
        """Queues one line."""
        if not self.closed:
            self.output += line.encode('ascii', 'replace') + b'\r\n'

    def close(self) -> None:
        """Ends the session after what is queued."""
        self.phase = Phase.CLOSED
        self.server.forget(self)

    def receive(self, data: bytes) -> None:
        """Takes bytes from the client, in any chunks."""
        self.last_received = self.server.clock.now
        self._input += data.replace(b'\r', b'\n')
        while not self.closed:
            line, end, rest = bytes(self._input).partition(b'\n')
            if len(line) > MAX_COMMAND:
                self.send('String too long')
                self.close()
            elif not end:
                break
            else:
                self._input = bytearray(rest)
                self._take(_TELNET.sub(b'', line).decode('ascii', 'ignore').strip())

    def _take(self, line: str) -> None:
        if not line:
            return
        if self.phase is Phase.LOGIN:
            self._log_in(line)
        else:
            if self.echo:
                self.send(line)
            self.server.execute(self, line)

    def _log_in(self, password: str) -> None:
        if not hmac.compare_digest(password.encode(), self.server.password.encode()):
            self.close()
            return
        self.phase = Phase.OPEN
        self.send('Welcome to the server.')
        self.send("You can type 'help' at any time for the following help list.")
        for line in help_lines():
            self.send(line)


class ArclServer:
    """The interface of one robot."""

    def __init__(self, clock: Clock, robot: Robot, password: str) -> None:
        self.clock, self.robot, self.password = clock, robot, password
        self.sessions: List[Session] = []
        self._count = 0
        robot.announce = self.broadcast

    def connect(self) -> Session:
        """A client has connected."""
        self._count += 1
        session = Session(self, self._count)
        self.sessions.append(session)
        return session

    def connect_outgoing(self) -> Session:
        """The robot's outgoing connection stands: no login, and every broadcast goes there too."""
        session = Session(self, 0, outgoing=True)
        self.sessions.append(session)
        return session

    def forget(self, session: Session) -> None:
        """The connection is gone."""
        session.phase = Phase.CLOSED
        if session in self.sessions:
            self.sessions.remove(session)

    def broadcast(self, line: str) -> None:
        """Sends a line to everybody who is logged in."""
        for session in self.sessions:
            if session.phase is Phase.OPEN:
                session.send(line)

    def execute(self, session: Session, line: str) -> None:
        """Carries out one command line for `session`."""
        name, _, rest = line.partition(' ')
        row = TABLE.get(name.lower())
        if row is None:
            session.send(f'Unknown command {name[:UNKNOWN_NAME]}')
            return
        call = Call(self, session, line, rest)
        if len(call.arguments) < row.least:
            session.send(f'usage: {row.usage}')
            return
        try:
            row.handler(call)
        except CommandFailed as failure:
            session.send(f'CommandError: {line}')
            session.send(f'CommandErrorDescription: {failure}')
        except SetUpError as failure:
            session.send(f'SetUpError: {failure}')


class OutgoingLists:
    """The command lists that the robot carries out for its outgoing link, each at its interval.

    `lists` maps seconds to commands separated by `|`; times count from the connection, so the
    lists do not drift.
    """

    def __init__(self, server: ArclServer, session: Session, lists: Dict[int, tuple]) -> None:
        self._server, self._session = server, session
        self._start = server.clock.now
        self._timers: Dict[int, Optional[Timer]] = {}
        for index, (seconds, commands) in lists.items():
            if seconds > 0 and commands.strip():
                self._arm(index, 1, seconds, commands)

    def _arm(self, index: int, count: int, seconds: float, commands: str) -> None:
        def run() -> None:
            if self._session.closed:
                return
            for text in commands.split('|'):
                if text.strip():
                    self._server.execute(self._session, text.strip())
            self._arm(index, count + 1, seconds, commands)

        self._timers[index] = self._server.clock.at(self._start + count * seconds, run)
