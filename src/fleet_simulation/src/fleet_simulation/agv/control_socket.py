"""The control port of simulated AGVs on loopback: `where` asks for poses, all other lines inject
faults.
"""
from __future__ import annotations

import json
import selectors
import socketserver
import threading
from typing import Callable, Mapping

from browser_guard import is_http_request

LONGEST_LINE = 1000  # bytes
QUIET = 60.0         # s; a connection on which no line comes for this time is closed


class AgvControlServer(socketserver.ThreadingTCPServer):
    """Answers each line with `ok`, `error: <sentence>`, or one line of JSON.

    `inject` and `where` are called in threads of the server.
    """

    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, port: int, inject: Callable[[str], None],
                 where: Callable[[], Mapping[str, object]]) -> None:
        """Listens on this port of 127.0.0.1; 0: a free port. Raises OSError."""
        super().__init__(('127.0.0.1', port), _Conversation)
        self.inject, self.where = inject, where
        self.port: int = self.server_address[1]
        threading.Thread(target=self.serve_forever, name='control', daemon=True).start()

    def answer(self, line: str) -> str:
        """Returns the answer to one line."""
        if line.lower() == 'where':
            return json.dumps(self.where())
        try:
            self.inject(line)
        except ValueError as error:
            return f'error: {error}'
        return 'ok'


class _Conversation(socketserver.StreamRequestHandler):
    timeout = QUIET
    rbufsize = 0  # without a buffer, so that `select` sees each line that was received

    def handle(self) -> None:
        assert isinstance(self.server, AgvControlServer)
        waiting = selectors.DefaultSelector()  # the watchdog does not report this wait as a hang
        waiting.register(self.connection, selectors.EVENT_READ)
        try:
            is_first = True
            while waiting.select(QUIET):
                line = self.rfile.readline(LONGEST_LINE)
                if not line.endswith(b'\n') or (is_first and is_http_request(line)):
                    return
                is_first = False
                words = line.decode('utf-8', 'replace').strip()
                self.wfile.write(self.server.answer(words).encode() + b'\n')
        except OSError:
            return  # the other end closed the connection
        finally:
            waiting.close()
