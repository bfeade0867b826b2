"""A client on a socket, and a room to drive in."""
from __future__ import annotations

import socket
from typing import List


class Talk:
    """A client on a socket; every wait has a time limit."""

    def __init__(self, port: int, password: str = 'adept') -> None:
        self.sock = socket.create_connection(('127.0.0.1', port), timeout=60.0)
        self._lines = self.sock.makefile('r', newline='\r\n', encoding='ascii')
        if password:
            self.send(password)
            self.until('End of commands')

    def send(self, line: str) -> None:
        self.sock.sendall(line.encode() + b'\r\n')

    def until(self, beginning: str) -> List[str]:
        seen = []
        while not seen or not seen[-1].startswith(beginning):
            line = self._lines.readline()
            assert line, f'closed before {beginning!r}, after {seen}'
            seen.append(line.rstrip('\r\n'))
        return seen

    def ended(self) -> bool:
        """Waits for the end of the connection."""
        try:
            return self._lines.read() == ''
        except ConnectionResetError:
            return True

    def close(self) -> None:
        self._lines.close()
        self.sock.close()


def to_the_end(sock: socket.socket, size: int = 4096) -> bytes:
    """Returns everything that arrives until the connection ends."""
    return b''.join(iter(lambda: sock.recv(size), b''))
