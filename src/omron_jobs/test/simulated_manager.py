"""A simulated Fleet Manager on loopback. Its link can be cut at any word of either side."""
from __future__ import annotations

import contextlib
import select
import socket
import threading
from dataclasses import dataclass
from typing import Callable, List, Optional

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.fleet_manager import SimFleetManager
from omron_ld90_sim.interface.session import LoginPhase, SimSession

PASSWORD = 'p'


class Robot:
    """A robot; the test ends its drives."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.ended: List[Callable[[bool], None]] = []

    @property
    def is_free(self) -> bool:
        """Whether it does nothing."""
        return not self.ended

    def drive(self, goal: str, ended: Callable[[bool], None]) -> None:
        """Begins a drive."""
        self.ended = [ended]

    def stop(self) -> None:
        """Ends the drive."""
        self.ended = []

    def end_drive(self, is_there: bool) -> None:
        """Ends the drive, at its goal or before."""
        ended, self.ended = self.ended, []
        for call in ended:
            call(is_there)


@dataclass(frozen=True)
class Cut:
    """The place at which the link is cut: after `words` of the Fleet Manager, or at a line of the
    client that begins with `words`.

    is_heard     -- whether `words` are from a line of the client
    is_delivered -- whether this line still arrives
    """

    words: bytes
    is_heard: bool = False
    is_delivered: bool = False


class ManagerPort:
    """The Fleet Manager with one robot, which drives only while `drives` is set; a context manager.

    Tests set and read its attributes; one thread owns the sockets.
    """

    def __init__(self, password: str = PASSWORD) -> None:
        self.robot = Robot('r1')
        self.manager = SimFleetManager(SimClock(), [self.robot], lambda: ['x', 'y'], password)
        self.cut: Optional[Cut] = None
        self.drives, self.mute = True, False
        self.chunk = 1 << 20                # bytes that are sent at a time
        self.before = b''                   # to be sent before the next answer
        self.swallowed: Optional[bytes] = None      # lines that begin with this are ignored
        self.heard: List[str] = []
        self.logins = 0
        self._server = socket.create_server(('127.0.0.1', 0))
        self.port: int = self._server.getsockname()[1]
        self._client: Optional[socket.socket] = None
        self._unread = b''
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> ManagerPort:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.set()
        self._thread.join(10.0)
        self._hang_up()
        self._server.close()

    def commands(self, word: str) -> List[str]:
        """The lines of the client that begin with a word."""
        return [line for line in self.heard if line.lower().startswith(word.lower())]

    def _run(self) -> None:
        while not self._closing.is_set():
            ends = [self._server] if self._client is None else [self._client]
            ready, _, _ = select.select(ends, [], [], 0.01)
            if ready and self._client is None:
                self._client, _ = self._server.accept()
                self._session: SimSession = self.manager.connect()
                self._unread = b''
                self.logins += 1
            elif ready and self._client is not None:
                self._receive(self._client)
            self.manager.clock.advance(self.manager.clock.now + 0.2)
            if self.drives:
                self.robot.end_drive(True)
            if self._client is not None:
                self._send(self._client)

    def _receive(self, client: socket.socket) -> None:
        try:
            data = client.recv(1 << 16)
        except OSError:
            data = b''
        if not data:
            self._hang_up()
            return
        *whole, self._unread = (self._unread + data).split(b'\n')
        for line in whole:
            if self.swallowed is not None and line.lower().startswith(self.swallowed):
                continue
            is_cut = (self.cut is not None and self.cut.is_heard
                      and line.lower().startswith(self.cut.words.lower()))
            if not is_cut or (self.cut is not None and self.cut.is_delivered):
                self.heard.append(line.decode().strip())
                self._session.receive(line + b'\n')
            if is_cut:
                self.cut = None
                self._hang_up()
                return

    def _send(self, client: socket.socket) -> None:
        data = bytes(self._session.output)
        self._session.output.clear()
        is_over = self._session.phase is LoginPhase.CLOSED
        if not (data or is_over) or self.mute and not is_over:
            return
        data, self.before = self.before + data, b''
        cut = self.cut
        end = data.find(cut.words) if cut is not None and not cut.is_heard else -1
        if cut is not None and end >= 0:
            data, self.cut = data[:end + len(cut.words)], None
        with contextlib.suppress(OSError):      # the client has closed it
            for begin in range(0, len(data), self.chunk):
                client.sendall(data[begin:begin + self.chunk])
        if end >= 0 or is_over:
            self._hang_up()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._session.close(abort=True)
            self._client.close()
            self._client = None
