"""A separate ROS master that a test can kill, restart at its port, and suspend."""
from __future__ import annotations

import signal
import subprocess
import time
from contextlib import contextmanager
from typing import Iterator

import rosgraph

from ports import free_port

STARTED = 20.0  # s within which it must answer


class RosMaster:
    """A ROS master; see the docstring of the module. It answers when the object has been made."""

    def __init__(self) -> None:
        self.port = free_port()
        self.uri = f'http://127.0.0.1:{self.port}'
        self.start()

    def start(self) -> None:
        """Starts the master. Returns when it answers."""
        self._process = subprocess.Popen(['rosmaster', '--core', '-p', str(self.port)],
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + STARTED
        while not rosgraph.is_master_online(self.uri):
            if time.monotonic() > deadline:
                raise AssertionError(f'no ROS master at {self.uri} within {STARTED:.0f} s')
            time.sleep(0.05)

    @property
    def pid(self) -> int:
        """The process id of the master."""
        return self._process.pid

    def kill(self) -> None:
        """Kills the master without a shutdown."""
        self._process.kill()
        self._process.wait(10)

    @contextmanager
    def hangs(self) -> Iterator[None]:
        """Suspends the master during the `with` block, so that it does not answer."""
        self._process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self._process.send_signal(signal.SIGCONT)
