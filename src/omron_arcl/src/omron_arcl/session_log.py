"""A file with all that both sides said, and when, in the format that the simulator replays."""
from __future__ import annotations

import contextlib
import errno
import os
import stat
import threading
import time
from typing import Callable, TextIO

SIZE = 50_000_000  # bytes of a file
OUTGOING = 0  # number of the connection that the robot opens itself

_ESCAPED = {byte: f'\\x{byte:02x}' for byte in (*range(32), *range(127, 256))}
_ESCAPED[ord('\\')] = '\\\\'


class SessionLog:
    """Writes what both sides say, in the format of docs/reference/session_log.md, times since 1970.

    Passwords come redacted already. A file that is there is kept as `<path>.old`, and so is one
    that has grown to `size` bytes: both together never take more than twice that. Raises OSError
    where the file cannot be opened, or is no regular file. A full disk ends the log, not the
    session: `failure` says so.
    """

    def __init__(self, path: str, size: int = SIZE) -> None:
        self.path = path
        self._size = size
        self._written = 0
        self.failure = ''
        self._connections = 0
        self._lock = threading.Lock()
        if os.path.exists(path) and not stat.S_ISREG(os.stat(path).st_mode):
            raise OSError(errno.EINVAL, 'it is there already, and is no regular file', path)
        self._file = self._begin()

    def _begin(self) -> TextIO:
        """A new file; the last one becomes the old one."""
        if os.path.exists(self.path):
            os.replace(self.path, f'{self.path}.old')
        self._written = 0
        return open(self.path, 'w', encoding='ascii', buffering=1)

    def connection(self) -> Callable[[str, bytes], None]:
        """The trace of a new connection to the robot."""
        self._connections += 1
        return self._trace('' if self._connections == 1 else str(self._connections))

    def outgoing(self) -> Callable[[str, bytes], None]:
        """The trace of a connection that the robot opened."""
        return self._trace(str(OUTGOING))

    def close(self) -> None:
        """Closes the file."""
        with self._lock, contextlib.suppress(OSError):
            self._file.close()

    def _trace(self, number: str) -> Callable[[str, bytes], None]:
        def write(side: str, line: bytes) -> None:
            text = line.decode('latin-1').translate(_ESCAPED)
            entry = f'{time.time():.3f} {side}{number}> {text}\n'
            with self._lock:
                try:
                    if self._file.closed:
                        return
                    if self._written and self._written + len(entry) > self._size:
                        self._file.close()
                        self._file = self._begin()
                    self._file.write(entry)
                    self._written += len(entry)
                except OSError as error:
                    self.failure = f'{self.path} ends here: {error.strerror or error}'
                    with contextlib.suppress(OSError):  # it would write what is left
                        self._file.close()
        return write
