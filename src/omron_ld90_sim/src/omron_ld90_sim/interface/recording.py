"""Session logs: `--log` writes them, `--replay` plays them back.

docs/reference/session_log.md describes the format. The controller's `~session_log` also uses it.
"""
from __future__ import annotations

import re
from collections import deque
from dataclasses import dataclass
from typing import Deque, Dict, List, Optional, TextIO

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.configuration import RobotConfiguration
from omron_ld90_sim.interface.configuration_table import default_configuration
from omron_ld90_sim.interface.session import HIDDEN, said

_LINE = re.compile(r'^(\d+(?:\.\d+)?) ([CS])(\d*)> ?(.*)$')
_ESCAPE = re.compile(rb'\\(?:\\|x([0-9a-f]{2}))')
_ESCAPED = {byte: f'\\x{byte:02x}' for byte in (*range(32), *range(127, 256))}
_ESCAPED[ord('\\')] = '\\\\'


def escape(line: bytes) -> str:
    """Returns the text of a line in the log."""
    return line.decode('latin-1').translate(_ESCAPED)


def unescape(text: str) -> bytes:
    """Returns the line that a text in the log represents."""
    return _ESCAPE.sub(lambda match: bytes.fromhex(match.group(1).decode()) if match.group(1)
                       else b'\\', text.encode('ascii', 'replace'))


OVERLAP = 0.5  # s for which the replay waits for a recorded command; then it skips the command


class LogError(ValueError):
    """A line of a session log is invalid."""


@dataclass(frozen=True)
class Transfer:
    """One line that was sent."""

    time: float
    direction: str      # 'C' from the client, 'S' from the robot
    connection: int     # 1, 2, ... in the order in which they began; 0: the outgoing one
    text: str           # escaped: printable ASCII

    def __str__(self) -> str:
        number = '' if self.connection == 1 else str(self.connection)
        return f'{self.time:.3f} {self.direction}{number}> {self.text}'


def read_log(lines: List[str]) -> List[Transfer]:
    """Returns the transfers of a log. Raises LogError, with the number of an invalid line."""
    transfers = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        match = _LINE.match(line.rstrip('\r\n'))
        if match is None:
            raise LogError(f'line {number} is no transfer, expected "<seconds> C> <text>" or '
                           f'"<seconds> S> <text>"')
        time, direction, connection, text = match.groups()
        transfers.append(Transfer(float(time), direction, int(connection or 1), text))
    return transfers


class SessionRecording:
    """Writes every transfer of one robot to a file, as it happens."""

    def __init__(self, clock: SimClock, file: TextIO) -> None:
        self._clock, self._file = clock, file

    def __call__(self, connection: int, direction: str, line: bytes) -> None:
        """Writes one line; a connection with a number below 0 is internal, and is left out."""
        if connection >= 0:
            transfer = Transfer(self._clock.now, direction, connection, escape(line))
            self._file.write(f'{transfer}\n')
            self._file.flush()


class ReplaySession:
    """One connection that is played back from a recording.

    Its attributes are the state of the connection, and the place in the recording.
    """

    def __init__(self, server: ReplayServer, number: int, script: List[Transfer]) -> None:
        self.server, self.number, self.outgoing = server, number, number == 0
        self.output = bytearray()
        self.closed = self.aborted = False
        self._script: Deque[Transfer] = deque(script)
        self._asked: Deque[bytes] = deque()
        self._is_asked = False  # whether no line has followed the last recognised command
        self._input = b''
        self._shift = server.clock.now - (script[0].time if script else 0.0)
        self._send_due_lines()

    @property
    def finished(self) -> bool:
        """Whether it is closed and everything has been sent."""
        return self.closed and not self.output

    def receive(self, data: bytes) -> None:
        """Takes bytes from the client; each of its lines triggers the recorded answers."""
        *lines, self._input = (self._input + data.replace(b'\r', b'\n')).split(b'\n')
        self._asked.extend(filter(None, map(said, lines)))
        self._send_due_lines()

    def _send_due_lines(self) -> None:
        """Sends the recorded lines that are due, until the client must send the next command."""
        clock = self.server.clock
        while self._script and not self.closed:
            head = self._script[0]
            due = head.time + self._shift
            if head.direction == 'S':
                if due > clock.now:
                    clock.at(due, self._send_due_lines)
                    return
                self.output += unescape(head.text) + b'\r\n'
                self._script.popleft()
                self._is_asked = False
            elif self._asked:
                self._answer(self._asked.popleft())
            elif not self._is_asked:
                return
            elif due + OVERLAP > clock.now:
                clock.at(due + OVERLAP, self._send_due_lines)
                return
            else:  # this client did not send that command
                self._script.popleft()

    def _answer(self, line: bytes) -> None:
        """Continues the recording after `line`; if `line` was not recorded, answers that it is an
        unknown command.
        """
        for skipped, transfer in enumerate(self._script):
            recorded = unescape(transfer.text)
            if transfer.direction == 'C' and recorded.lower() in (line.lower(), HIDDEN):
                self._shift = self.server.clock.now - transfer.time
                for _ in range(skipped + 1):
                    self._script.popleft()
                self._is_asked = True
                return
        self.output += b'Unknown command ' + line.split()[0] + b'\r\n'

    def close(self, abort: bool = False) -> None:
        """Ends the session."""
        self.aborted, self.closed = abort, True
        self.server.forget(self)


class ReplayServer:
    """Plays back a recording instead of a robot.

    A client without a recorded connection of its own gets the first recorded connection.
    """

    def __init__(self, clock: SimClock, transfers: List[Transfer],
                 configuration: Optional[RobotConfiguration] = None) -> None:
        self.clock, self.configuration = clock, configuration or default_configuration()
        self.online = self.accepting = self.outgoing_wanted = True
        self.sessions: List[ReplaySession] = []
        self._scripts: Dict[int, List[Transfer]] = {}
        for transfer in transfers:
            self._scripts.setdefault(transfer.connection, []).append(transfer)
        self._count = 0

    def connect(self) -> ReplaySession:
        """Begins the next recorded connection for a new client."""
        self._count += 1
        number = self._count if self._count in self._scripts else 1
        return self._begin(number)

    def connect_outgoing(self) -> ReplaySession:
        """Begins the recorded outgoing connection."""
        return self._begin(0)

    def _begin(self, number: int) -> ReplaySession:
        session = ReplaySession(self, number, self._scripts.get(number, []))
        self.sessions.append(session)
        return session

    def forget(self, session: ReplaySession) -> None:
        """Removes a connection that has ended."""
        session.closed = True
        if session in self.sessions:
            self.sessions.remove(session)

    def shut_down(self) -> None:
        """Ends all connections."""
        self.online = False
        for session in list(self.sessions):
            session.close()
