"""The ARCL server without I/O: sessions that take bytes and hold the bytes to send.

A `Session` is one connection. Replies go to the session that asked; `ArclServer.broadcast` goes to
every logged-in one, the outgoing link included. Framing and login are those of the facts: lines end
with CRLF, LF or CR, a wrong password closes without a word, a command over 5,000 characters drops
the client.
"""
from __future__ import annotations

import hmac
import re
import time
from collections import deque
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Callable, Deque, Dict, List, Optional, Tuple

from omron_ld90.maps import MapDocument, MapError
from omron_ld90_sim.clock import Clock, Ticker
from omron_ld90_sim.commands import TABLE, Call, CommandFailed, SetUpError, help_lines
from omron_ld90_sim.configuration import FILES, SERVER, Configuration
from omron_ld90_sim.data_store import DataStore
from omron_ld90_sim.floor import Floor
from omron_ld90_sim.robot import Robot

MAX_COMMAND = 5000
CYCLE = 0.1                 # s between two looks of the server at what its clients have sent
PROMPT = 'Enter password:'
LEAST_TIMEOUT = 60.0        # s, SessionTimeoutMins never means less
HIDDEN = '********'         # what a log shows in place of the password
BLANK = ' \t\0'            # around a line; telnet sends a NUL behind a CR
_TELNET = re.compile(rb'^(?:\xff[\xfb-\xfe].|[\x80-\xff])+', re.DOTALL)
_VARIABLE = re.compile(r'\$([gymdHMSTXY])')


def text_of(line: bytes) -> str:
    """What a client's line says, without telnet negotiation and what is not ASCII."""
    return _TELNET.sub(b'', line).decode('ascii', 'ignore').strip(BLANK)


class Phase(Enum):
    """How far a session is."""

    LOGIN = 'login'
    OPEN = 'open'
    CLOSED = 'closed'


@dataclass
class Impairment:
    """What is wrong with the network, on demand (`faults`)."""

    delay: float = 0.0                  # s that every line comes late
    silent_until: float = 0.0           # nothing is sent before
    half_line: Optional[float] = None   # the next line is cut, its rest comes this much later
    prompt: str = PROMPT


class Session:
    """One connection of a client, or the robot's own outgoing one."""

    def __init__(self, server: ArclServer, number: int, outgoing: bool = False) -> None:
        self.server, self.number, self.outgoing = server, number, outgoing
        self.output = bytearray()
        self.echo: Optional[bool] = None        # None until it is set: see _echo_typed
        self.task_list: Optional[list] = None   # what listAdd adds to
        self.aborted = False            # ends with RST, what is queued is lost
        self.phase = Phase.OPEN if outgoing else Phase.LOGIN
        self.last_received = server.clock.now
        self._input = b''               # a line whose end has not come yet
        self._echoed = 0                # bytes of it that went back
        self._held: Deque[Tuple[float, bytes]] = deque()
        if not outgoing:
            self.send(server.impairment.prompt)

    @property
    def closed(self) -> bool:
        """Whether the connection ends once `output` has been sent."""
        return self.phase is Phase.CLOSED

    def send(self, line: str) -> None:
        """Queues one line."""
        if self.closed:
            return
        self.server.log(self.number, 'S', line)
        data = line.encode('ascii', 'replace') + b'\r\n'
        fault = self.server.impairment
        if fault.half_line is not None and self.phase is Phase.OPEN:
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
        """Ends the session, after what is queued unless it is aborted."""
        self.aborted = abort
        if abort:
            self.output.clear()
        self.phase = Phase.CLOSED
        self.server.forget(self)

    def receive(self, data: bytes) -> None:
        """Takes bytes from the client, in any chunks."""
        self.last_received = self.server.clock.now
        *lines, self._input = (self._input + data.replace(b'\r', b'\n')).split(b'\n')
        for line in lines:
            if self._echoed:
                self._put(b'\n\r')
                self._echoed = 0
            if self._accepts(line):
                self._take(text_of(line))
        if self._accepts(self._input) and self._input:
            self.server.clock.after(CYCLE, self._echo_typed)

    def _accepts(self, line: bytes) -> bool:
        """Whether to go on with a line; a client that sends a longer one is dropped."""
        if len(line) > MAX_COMMAND:
            self.send('String too long')
            self.close()
        if line >= b'\x80' and self.echo is None:
            self.echo = False       # telnet negotiation: such a client shows what is typed itself
        return not self.closed

    def _echo_typed(self) -> None:
        """Gives back what stands of an unfinished line, as the server does until `echo` is set."""
        if self.echo is None and not self.closed:
            typed = self._input[self._echoed:].decode('ascii', 'ignore')
            self._put(typed.encode())
            self._echoed = len(self._input)

    def _take(self, line: str) -> None:
        if not line:
            return
        if self.phase is Phase.LOGIN:
            self.server.log(self.number, 'C', HIDDEN)
            self._log_in(line)
        else:
            self.server.log(self.number, 'C', line)
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

    def __init__(self, clock: Clock, robot: Robot, password: str,
                 configuration: Optional[Configuration] = None,
                 map_folder: Optional[Path] = None, robot_name: str = 'robot') -> None:
        """`map_folder` is where the maps lie that `configAdd Map` may name."""
        self.clock, self.robot, self.password = clock, robot, password
        self.robot_name = robot_name
        self.configuration = configuration or Configuration()
        self.map_folder = map_folder
        self.sessions: List[Session] = []
        self.impairment = Impairment()
        self.online = True              # off: no listener and no outgoing connection
        self.accepting = True           # off: new connections are refused
        self.outgoing_wanted = True     # off: the outgoing connection stays away
        self.log: Callable[[int, str, str], None] = lambda number, direction, text: None
        self.wall_time = time.localtime
        self.data_store = DataStore(robot, lambda: self.wall_time())
        self._count = 0
        robot.announce = self.broadcast
        Ticker(clock, LEAST_TIMEOUT / 4, self._drop_silent)

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

    def drop_all(self, abort: bool = False) -> None:
        """Ends every connection, the outgoing one included."""
        for session in list(self.sessions):
            session.close(abort)

    def shut_down(self) -> None:
        """Ends the server: farewell, then no port and no connection."""
        for session in list(self.sessions):
            session.send('Shutting down server')
        self.online = False
        self.drop_all()

    def restart(self, seconds: float, abort: bool = False) -> None:
        """The robot's software is gone for so long, with a farewell or without (`abort`)."""
        if abort:
            self.online = False
            self.drop_all(abort)
        else:
            self.shut_down()
        self.robot.halt()

        def up() -> None:
            self.online = True

        self.clock.after(seconds, up)

    def _drop_silent(self) -> None:
        minutes = self.configuration.number(SERVER, 'SessionTimeoutMins')
        if minutes >= 0:
            limit = max(minutes * 60.0, LEAST_TIMEOUT)
            for session in list(self.sessions):
                if not session.outgoing and self.clock.now - session.last_received >= limit:
                    session.close()

    def broadcast(self, line: str) -> None:
        """Sends a line to everybody who is logged in."""
        for session in list(self.sessions):
            if session.phase is Phase.OPEN:
                session.send(line)

    def execute(self, session: Session, line: str) -> None:
        """Carries out one command line for `session`."""
        line = _VARIABLE.sub(self._variable, line)
        name, rest = [*line.split(None, 1), '', ''][:2]
        row = TABLE.get(name.lower())
        if row is None:
            session.send(f'Unknown command {name}')
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

    def _variable(self, match: re.Match) -> str:
        pose, now = self.robot.pose, self.wall_time()
        x, y, theta = (int(round(value)) for value in (pose.x, pose.y, pose.theta))
        values: Dict[str, str] = {
            'g': self.robot.last_goal, 'y': f'{now.tm_year}', 'm': f'{now.tm_mon:02d}',
            'd': f'{now.tm_mday:02d}', 'H': f'{now.tm_hour:02d}', 'M': f'{now.tm_min:02d}',
            'S': f'{now.tm_sec:02d}', 'T': f'{theta}', 'X': f'{x}',
            'Y': f'{y}'}
        return values[match.group(1)]

    def switch_map(self, name: str) -> None:
        """Loads another map from the map folder; ValueError with a sentence when it cannot."""
        if self.map_folder is None or Path(name).name != name:
            raise ValueError(f"The file given did not exist: '{name}'")
        try:
            document = MapDocument.load(str(self.map_folder / name))
        except MapError as error:
            raise ValueError(str(error)) from error
        self.robot.halt()
        self.robot.load_map(document, Floor.from_map(document))
        self.configuration.set(FILES, 'Map', name)
        self.broadcast('Map changed')
