"""The control socket of a running simulation: faults, speed, and the robots' true poses."""
from __future__ import annotations

import errno
import json
import selectors
import socket
from typing import Callable, Mapping

from browser_guard import is_http_request
from omron_ld90_sim.interface.loop import Loop
from omron_ld90_sim.interface.numbers import speed_factor
from omron_ld90_sim.interface.transport import RECONNECT, PortTaken


class SimControlServer:
    """A line protocol on loopback.

    A line is a fault or `speed FACTOR`, answered with `ok` or `error: <sentence>`; or it is
    `where`, answered with one line of JSON.
    """

    MAX_LINE = 1000

    def __init__(self, loop: Loop, port: int, inject: Callable[[str], None],
                 where: Callable[[], Mapping[str, object]]) -> None:
        """`inject` raises ValueError, with a sentence, for a line that is no fault."""
        self._loop, self._inject, self._where = loop, inject, where
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
        self._listen()

    def _listen(self) -> None:
        self._loop.selector.register(self._listener, selectors.EVENT_READ, self._accept)

    def _accept(self, mask: int) -> None:
        try:
            sock, _ = self._listener.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):     # no descriptor is free
                self._loop.selector.unregister(self._listener)
                self._loop.clock.after(RECONNECT, self._listen)
            return
        sock.setblocking(False)
        pending = bytearray()
        is_first = True

        def ready(mask: int) -> None:
            nonlocal is_first
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
                    if is_first and is_http_request(line):
                        raise ConnectionAbortedError('a web browser has connected')
                    is_first = False
                    sock.send(self._answer(line))
            except OSError:
                data = b''
            if not data or len(pending) > self.MAX_LINE:
                self._loop.selector.unregister(sock)
                sock.close()

        self._loop.selector.register(sock, selectors.EVENT_READ, ready)

    def _answer(self, line: bytes) -> bytes:
        words = line.decode('utf-8', 'replace').strip()
        if words.lower() == 'where':
            return json.dumps(self._where()).encode() + b'\n'
        try:
            name, _, factor = words.partition(' ')
            if name.lower() == 'speed':
                self._loop.set_speed(speed_factor(factor))
            else:
                self._inject(words)
        except ValueError as error:
            return f'error: {error}\n'.encode()
        return b'ok\n'
