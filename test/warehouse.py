"""A warehouse program for tests and benchmarks of job_server."""
from __future__ import annotations

import socket
import time
from pathlib import Path
from typing import Iterator, List

PASSWORD = (Path(__file__).resolve().parents[1]
            / 'src/omron_ld90_sim/config/simulator_password').read_bytes().strip()
PATIENCE = 90.0


class Warehouse:
    """A program that splits lines at blanks, like programs of warehouses."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(('127.0.0.1', port), timeout=PATIENCE)
        self._lines = self._socket.makefile('r', newline='\r\n')
        self.say(PASSWORD.decode())
        self.until('End of commands')

    def say(self, line: str) -> None:
        self._socket.sendall(line.encode() + b'\n')

    def lines(self) -> Iterator[str]:
        """Returns all lines until the connection ends."""
        return iter(self._lines)

    def until(self, *words: str) -> List[str]:
        """Returns the words of the first line that has all `words`; fails at an error or at the
        end.
        """
        for line in self._lines:
            found = line.rstrip('\r\n').split(' ')
            if all(word in line for word in words):
                return found
            if found[0] == 'CommandErrorDescription:':
                raise AssertionError(line)
        raise AssertionError(f'the connection ended before {words}')

    def close(self) -> None:
        self._lines.close()
        self._socket.close()


def connected(port: int) -> Warehouse:
    """Returns a warehouse program that is logged in, as soon as the server listens."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return Warehouse(port)
        except (OSError, AssertionError):
            if time.monotonic() > end:
                raise
            time.sleep(0.2)
