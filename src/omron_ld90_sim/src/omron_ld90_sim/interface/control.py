"""The control socket: faults on demand for a simulation that runs."""
from __future__ import annotations

import selectors
import socket
from typing import Callable

from omron_ld90_sim.interface.transport import Loop, PortTaken


class ControlServer:
    """A line protocol on loopback for faults: `ok` or `error: <sentence>` for each line."""

    MAX_LINE = 1000

    def __init__(self, loop: Loop, port: int, inject: Callable[[str], None]) -> None:
        self._loop, self._inject = loop, inject
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(('127.0.0.1', port))
        except OSError as error:
            listener.close()
            raise PortTaken(f'control port {port} cannot be used ({error.strerror}): choose '
                            f'another one with --control') from error
        listener.listen(4)
        listener.setblocking(False)
        self.port: int = listener.getsockname()[1]
        self._listener = listener
        loop.selector.register(listener, selectors.EVENT_READ, self._accept)

    def _accept(self, mask: int) -> None:
        try:
            sock, _ = self._listener.accept()
        except OSError:
            return
        sock.setblocking(False)
        pending = bytearray()

        def ready(mask: int) -> None:
            try:
                data = sock.recv(4096)
            except BlockingIOError:
                return
            except OSError:
                data = b''
            pending.extend(data)
            try:
                while b'\n' in pending:
                    line, _, rest = bytes(pending).partition(b'\n')
                    pending[:] = rest
                    sock.send(self._answer(line))
            except OSError:
                data = b''
            if not data or len(pending) > self.MAX_LINE:
                self._loop.selector.unregister(sock)
                sock.close()

        self._loop.selector.register(sock, selectors.EVENT_READ, ready)

    def _answer(self, line: bytes) -> bytes:
        try:
            self._inject(line.decode('utf-8', 'replace').strip())
        except ValueError as error:
            return f'error: {error}\n'.encode()
        return b'ok\n'
