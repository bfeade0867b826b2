"""Common parts of the tests of ARCL: transcripts of sessions, and a robot that the test controls.

The transcripts come from a real LD-90. If there is none for a case, they come from the manual.
"""
from __future__ import annotations

import socket
import struct
import threading
import time
from typing import Any, Callable, List, Optional, Set, Tuple

from omron_arcl import Execution, Outcome, Received, parse_command, parse_line
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.records import Doubt
from omron_arcl.session import Closed, Event, Session

PASSWORD = b'adept'
HELP_LIST = (
    b'Commands:',
    b'           echo          with no args gets echo, with args sets echo',
    b'       getGoals          gets a list of goals in the map',
    b'           goto          Goes to a goal',
    b'           help          gives the listing of available commands',
    b'applicationFaultQuery          Gets the list of any application faults currently triggered'
    b' [afq]',
    b'           quit          closes this connection to the server',
    b'End of commands',
)
LOGIN = (b'Enter password:', b'Welcome to the server.',
         b"You can type 'help' at any time for the following help list.", *HELP_LIST)

STATUS = (
    b'ExtendedStatusForHumans: Going to 12',
    b'Status: Going to 12',
    b'StateOfCharge: 79.4',
    b'Location: 3120 -540 -87',
    b'LocalizationScore: 0.870543',
    b'Temperature: 36',
)
UNDOCKED = 'DockingState: Undocked ForcedState: Unforced ChargeState: Not'
GOTO_FROM_DOCK = (
    'DockingState: Undocking ForcedState: Unforced ChargeState: Float',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Not',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Overcharge',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Bulk',
    UNDOCKED,
    'Going to 12',
    'Arrived at 12',
)
DOCK = (
    UNDOCKED,
    'DockingState: Docking ForcedState: Unforced ChargeState: Not',
    'DockingState: Docking ForcedState: Unforced ChargeState: Bulk',
    'DockingState: Docked ForcedState: Unforced ChargeState: Bulk',
    'DockingState: Docked ForcedState: Unforced ChargeState: Overcharge',
)
UNDOCK = (
    'DockingState: Undocking ForcedState: Unforced ChargeState: Overcharge',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Not',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Overcharge',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Not',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Bulk',
    'DockingState: Undocking ForcedState: Unforced ChargeState: Not',
    UNDOCKED,
    'Stopping',
    'Stopped',
)


def lines(*texts: bytes) -> bytes:
    """The lines as the robot sends them."""
    return b''.join(text + b'\r\n' for text in texts)


def logged_in() -> Session:
    """A session after its login."""
    session = Session(PASSWORD)
    session.receive(lines(*LOGIN))
    session.pop_output()
    return session


def feed_whole(session: Session, data: bytes) -> List[Event]:
    return session.receive(data)


def feed_byte_by_byte(session: Session, data: bytes) -> List[Event]:
    return [event for i in range(len(data)) for event in session.receive(data[i:i + 1])]


def feed_with_trailing_data(session: Session, data: bytes) -> List[Event]:
    """Feeds the data and the beginning of an unfinished line, all in one piece."""
    return session.receive(data + b'Arrived at 1')


FEEDS = (feed_whole, feed_byte_by_byte, feed_with_trailing_data)


def texts(events: List[Event]) -> List[str]:
    """The lines among `events`."""
    return [event.text for event in events if isinstance(event, Received)]


def closing(events: List[Event]) -> Closed:
    """The last event, which must be the end of the session."""
    assert events and isinstance(events[-1], Closed), f'not closed: {events}'
    return events[-1]


class Conversation:
    """A dispatcher with its own clock; the test plays the robot line by line."""

    def __init__(self) -> None:
        self.dispatcher = Dispatcher()
        self.now = 0.0
        self.dispatcher.on_connected(self.now)
        self.sent: List[str] = []

    def give(self, text: str, **options: Any) -> Execution:
        """Gives a command, and sends the commands that may be sent now."""
        execution = self.dispatcher.start(parse_command(text), **options)
        self.send()
        return execution

    def send(self) -> None:
        """Sends the commands that may be sent now."""
        while True:
            line = self.dispatcher.next_to_send(self.now)
            if line is None:
                return
            self.sent.append(line.decode())

    def has_begun(self, execution: Execution) -> bool:
        """Returns whether the robot obeys a command or has begun to answer it."""
        return self.dispatcher.records.has_begun(execution)

    def doubt_of(self, execution: Execution) -> Optional[Doubt]:
        """The doubt on the record of a command under way."""
        record = self.dispatcher.records.record_of(execution)
        return record.doubt if record else None

    def cancel(self, execution: Execution) -> None:
        """Cancels a command. Lines that must be sent because of this are sent later."""
        self.dispatcher.cancel(execution, self.now)

    def robot(self, *said: str) -> None:
        """Plays lines of the robot, one tenth of a second apart."""
        for text in said:
            self.now += 0.1
            self.dispatcher.on_reply(parse_line(text), text, self.now)
            self.send()
            self.tell()

    def pass_time(self, seconds: float) -> None:
        """Lets the time pass without any line."""
        self.now += seconds
        self.dispatcher.on_time(self.now)
        self.send()
        self.tell()

    def tell(self) -> None:
        """Calls the callbacks that are due."""
        for callback in self.dispatcher.pop_callbacks():
            callback()


def outcome(execution: Execution) -> Outcome:
    """The outcome of a command, which must have ended."""
    assert execution.result is not None, f'"{execution.command.text}" is still under way'
    return execution.result.outcome


class ScriptedRobot:
    """A TCP server that logs clients in, notes their lines, and sends the lines of the test."""

    def __init__(self, password: bytes = PASSWORD, login: bool = True) -> None:
        self._password = password
        self._login = login
        self._server = socket.create_server(('127.0.0.1', 0))
        self.port: int = self._server.getsockname()[1]
        self.heard: List[bytes] = []
        self.connections: List[socket.socket] = []
        self.answers = {b'echo off': (b'Echo turned off.',)}
        self.unknown: Set[bytes] = set()
        self.mute = False
        self.hangs_up_on = b''  # on receiving this line, it closes the connection
        self._sending = threading.Lock()
        self._closing = False
        self._threads = [threading.Thread(target=self._accept, daemon=True)]
        self._threads[0].start()

    def __enter__(self) -> ScriptedRobot:
        return self

    def __exit__(self, *_: object) -> None:
        self._closing = True
        self.drop()
        self._server.shutdown(socket.SHUT_RDWR)
        self._server.close()
        for thread in self._threads:
            thread.join(5.0)

    def say(self, *texts: bytes) -> None:
        """Sends lines to the last client."""
        self.send(self.connections[-1], lines(*texts))

    def send(self, connection: socket.socket, data: bytes) -> None:
        """Sends bytes; bytes of other threads do not come in between."""
        with self._sending:
            connection.sendall(data)

    def drop(self, reset: bool = False) -> None:
        """Closes all connections; with RST if `reset`."""
        for connection in list(self.connections):  # later connections are not closed
            try:
                # with a linger of zero, closing sends RST; a shutdown of the reading side alone
                # would not be visible to the other side
                if reset:
                    linger = struct.pack('ii', 1, 0)
                    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
                connection.shutdown(socket.SHUT_RD if reset else socket.SHUT_RDWR)
            except OSError:
                continue  # the connection has ended already

    def forget_closed(self) -> None:
        """Releases the data of connections and threads that have ended."""
        self.connections[:] = [c for c in self.connections if c.fileno() >= 0]
        self._threads[1:] = [t for t in self._threads[1:] if t.is_alive()]

    def wait_heard(self, line: bytes, timeout: float = 20.0) -> None:
        wait_for(lambda: line in self.heard, f'the robot hears {line!r}, it heard {self.heard}',
                 timeout)

    def _accept(self) -> None:
        while not self._closing:
            try:
                connection, _ = self._server.accept()
            except OSError:
                return
            self.connections.append(connection)
            thread = threading.Thread(target=self._serve, args=(connection,), daemon=True)
            self._threads.append(thread)
            thread.start()

    def _serve(self, connection: socket.socket) -> None:
        with connection, connection.makefile('rb') as reader:
            try:
                if self._login:
                    self.send(connection, lines(LOGIN[0]))
                    if reader.readline().strip() != self._password:
                        return
                    self.send(connection, lines(*LOGIN[1:]))
                for line in reader:
                    self.heard.append(line.strip())
                    if line.strip() == self.hangs_up_on:
                        return
                    if not self.mute:
                        self.send(connection, lines(*self._answer(line.strip())))
            except (OSError, ValueError):
                return  # the other side, or the test, ended it

    def _answer(self, line: bytes) -> Tuple[bytes, ...]:
        if line in self.unknown:
            return (b'Unknown command ' + line,)
        if line == b'oneLineStatus':
            return (b'Status: Stopped StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36',)
        return self.answers.get(line, ())


def wait_for(condition: Callable[[], Any], what: str, timeout: float = 20.0) -> Any:
    """Polls until `condition` is true."""
    deadline = time.monotonic() + timeout
    while time.monotonic() < deadline:
        value = condition()
        if value:
            return value
        time.sleep(0.005)
    raise AssertionError(f'not within {timeout:.0f} s: {what}')


class Noted:
    """A callback that records its arguments."""

    def __init__(self) -> None:
        self.all: List[Any] = []

    def __call__(self, value: Any) -> None:
        self.all.append(value)

    def wait(self, condition: Callable[[Any], Any], what: str, timeout: float = 20.0,
             after: int = 0) -> Any:
        return wait_for(lambda: next((value for value in self.all[after:] if condition(value)),
                                     None), f'{what}; told: {self.all[-5:]}', timeout)


def free_port() -> int:
    """A port on which no program listens."""
    with socket.create_server(('127.0.0.1', 0)) as server:
        return server.getsockname()[1]
