"""A ROS master that no launch depends on: it can be killed, started anew on its port, and hang."""
from __future__ import annotations

import signal
import subprocess
import time
from contextlib import contextmanager
from typing import Iterator

import rosgraph

from ports import free_port

STARTED = 20.0  # s within which it answers


class RosMaster:
    """See the module's text; it answers as soon as it is made."""

    def __init__(self) -> None:
        self.port = free_port()
        self.uri = f'http://127.0.0.1:{self.port}'
        self.start()

    def start(self) -> None:
        """Returns once it answers."""
        self._process = subprocess.Popen(['rosmaster', '--core', '-p', str(self.port)],
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + STARTED
        while not rosgraph.is_master_online(self.uri):
            if time.monotonic() > deadline:
                raise AssertionError(f'no ROS master at {self.uri} within {STARTED:.0f} s')
            time.sleep(0.05)

    @property
    def pid(self) -> int:
        """Of its process."""
        return self._process.pid

    def kill(self) -> None:
        """Without a word."""
        self._process.kill()
        self._process.wait(10)

    @contextmanager
    def hangs(self) -> Iterator[None]:
        """Meanwhile it answers nothing."""
        self._process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self._process.send_signal(signal.SIGCONT)
