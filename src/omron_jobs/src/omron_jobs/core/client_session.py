"""The job server and its clients without I/O: login, lines in, lines out.

    phase   event                              next phase
            a client connects                  LOGIN; the server asks for the password
            the server connects by itself      OPEN; nothing is sent
    LOGIN   the right password                 OPEN; welcome and list of commands are sent
            another line                       CLOSED
    OPEN    a line                             OPEN; it is carried out; CLOSED after `quit`
    all     too long a line; the link ends     CLOSED

Only a client that connects to the server must give the password. The server carries out no command
before that. A reply goes to the client that sent the command. After the reply, the changes that the
command caused go to all clients, to each of them in the same order.
"""
from __future__ import annotations

import hmac
from enum import Enum
from typing import Callable, Iterable, List, Sequence

from omron_arcl.framing import LineBuffer, decode
from omron_jobs.core import job_words as words
from omron_jobs.core.job_commands import JobCommands, update_line
from omron_jobs.core.jobs import SegmentChange

LONGEST_COMMAND = 5000  # bytes
MOST_UNREAD = 2 ** 23   # bytes that may wait for a client


class ClientPhase(Enum):
    """The phase of a client."""

    LOGIN = 'login'
    OPEN = 'open'
    CLOSED = 'closed'


class ClientSession:
    """One client.

    output -- bytes to be sent to it
    echo   -- whether its lines are sent back
    """

    def __init__(self, server: JobServer, phase: ClientPhase) -> None:
        self.output = bytearray()
        self.phase = phase
        self.echo = False
        self._server = server
        self._input = LineBuffer(LONGEST_COMMAND)
        if phase is ClientPhase.LOGIN:
            self.send([words.PROMPT])

    def send(self, lines: Iterable[str]) -> None:
        """Queues lines."""
        self.send_bytes(written(lines))

    def send_bytes(self, data: bytes) -> None:
        """Queues lines that `written` has encoded."""
        if self.phase is not ClientPhase.CLOSED:
            self.output += data

    def receive(self, data: bytes) -> None:
        """Handles bytes of the client, in pieces of any size."""
        for line in self._input.feed(data):
            if self.phase is not ClientPhase.CLOSED:
                self._receive_line(line.strip())
                self._check_unread()
        if self._input.overflowed and self.phase is not ClientPhase.CLOSED:
            self.send([words.TOO_LONG])
            self.close()

    def _check_unread(self) -> None:
        """Ends the session of a client that does not read its replies."""
        if len(self.output) > MOST_UNREAD:
            self.output.clear()
            self.close()

    def _receive_line(self, line: bytes) -> None:
        if self.phase is ClientPhase.OPEN:
            self._server.carry_out(self, decode(line))
        elif hmac.compare_digest(line, self._server.password):
            self.phase = ClientPhase.OPEN
            self.send([*words.WELCOME])
            self._server.carry_out(self, 'help')
        else:
            self.close()

    def close(self) -> None:
        """Ends the session; queued bytes are still sent."""
        self.phase = ClientPhase.CLOSED
        self._server.forget(self)


class JobServer:
    """Carries out the commands of all clients, and sends changes to all of them.

    on_changes -- called with changes after they were sent to all clients
    """

    def __init__(self, commands: JobCommands, password: bytes) -> None:
        self.password = password
        self.sessions: List[ClientSession] = []
        self.on_changes: Callable[[Sequence[SegmentChange]], None] = lambda changes: None
        self._commands = commands

    def connect(self, phase: ClientPhase = ClientPhase.LOGIN) -> ClientSession:
        """Begins the session of a client."""
        session = ClientSession(self, phase)
        self.sessions.append(session)
        return session

    def forget(self, session: ClientSession) -> None:
        """Removes a session that has ended."""
        if session in self.sessions:
            self.sessions.remove(session)

    def carry_out(self, session: ClientSession, line: str) -> None:
        """Carries out a line of a client."""
        if session.echo:
            session.send([words.printed(line)])
        reply = self._commands.carry_out(line)
        session.send(reply.lines)
        if reply.echo is not None:
            session.echo = reply.echo
        self.announce(reply.changes)
        if reply.ends:
            session.close()

    def announce(self, changes: Iterable[SegmentChange]) -> None:
        """Sends changes to all clients that are logged in."""
        told = tuple(changes)
        if not told:
            return
        data = written(map(update_line, told))
        for session in list(self.sessions):
            if session.phase is ClientPhase.OPEN:
                session.send_bytes(data)
        self.on_changes(told)

    def shut_down(self) -> None:
        """Sends a farewell to all clients, and ends their sessions."""
        for session in list(self.sessions):
            session.send([words.SHUTTING_DOWN])
            session.close()


def written(lines: Iterable[str]) -> bytes:
    """Returns the bytes of lines, as they are sent."""
    return b''.join(line.encode('utf-8', 'replace') + b'\r\n' for line in lines)
