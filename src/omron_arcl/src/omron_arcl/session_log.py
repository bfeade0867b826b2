"""A file with all lines of both sides and their times, in the format that the simulator replays."""
from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
import threading
import time
from typing import Callable, TextIO

SIZE = 50_000_000  # bytes, maximum size of one file
OUTGOING = 0  # number of the connection that the robot opens itself

_LINE = re.compile(rb'\d+\.\d{3} [CS]\d*> ')  # the beginning of each line

_ESCAPED = {byte: f'\\x{byte:02x}' for byte in (*range(32), *range(127, 256))}
_ESCAPED[ord('\\')] = '\\\\'


class SessionLog:
    """Writes the lines of both sides in the format of docs/reference/session_log.md.

    Times are seconds since 1970. The lines that the log gets contain no passwords. At the start, an
    existing file becomes `<path>.old`. A file that has grown to `size` bytes becomes `<path>.old`
    as well, so both files together never take more than twice `size`. But a `<path>.old` that is
    not a session log is never replaced. Raises OSError if the file cannot be opened or is not a
    regular file, or if the older file cannot be kept. A full disk ends the log, but not the
    session; `failure` then has the reason.
    """

    def __init__(self, path: str, size: int = SIZE) -> None:
        self.path = path
        self._size = size
        self._written = 0
        self.failure = ''
        self._connections = 0
        self._lock = threading.Lock()
        if os.path.exists(path) and not stat.S_ISREG(os.stat(path).st_mode):
            raise OSError(errno.EINVAL, 'it exists and is no regular file', path)
        self._file = self._begin()

    def _begin(self) -> TextIO:
        """Opens a new file. The last file becomes `<path>.old`."""
        older = f'{self.path}.old'
        if os.path.exists(self.path):
            if os.path.exists(older) and not _is_session_log(older):
                raise OSError(errno.EEXIST, f'the last log cannot be kept as {older}, because '
                              'that file is no session log: rename it', self.path)
            os.replace(self.path, older)
        self._written = 0
        return open(self.path, 'w', encoding='ascii', buffering=1)

    def connection(self) -> Callable[[str, bytes], None]:
        """Returns the trace function of a new connection to the robot."""
        self._connections += 1
        return self._trace('' if self._connections == 1 else str(self._connections))

    def outgoing(self) -> Callable[[str, bytes], None]:
        """Returns the trace function of a connection that the robot opened."""
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
                    with contextlib.suppress(OSError):  # closing writes the rest, which may fail
                        self._file.close()
        return write


def _is_session_log(path: str) -> bool:
    """Returns whether the file looks like a session log, or is empty."""
    with open(path, 'rb') as file:
        begin = file.readline(100)
    return not begin or _LINE.match(begin) is not None
