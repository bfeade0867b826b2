"""A file with all that both sides said, and when."""
from __future__ import annotations

import threading
from datetime import datetime, timezone


class SessionLog:
    """Appends lines `<UTC time> C> <line>` (client) or `S>` (server); give `write` as a trace.

    What is not printable ASCII is escaped as Python does. Passwords come blanked already. Raises
    OSError where the file cannot be opened; a full disk ends the log, not the session.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.failure = ''
        self._lock = threading.Lock()
        self._file = open(path, 'a', encoding='ascii', buffering=1)  # noqa: SIM115  kept open

    def write(self, side: str, line: bytes) -> None:
        """Notes a line of side 'C' or 'S'."""
        now = datetime.now(timezone.utc).isoformat(timespec='milliseconds')
        text = line.decode('latin-1').encode('unicode_escape').decode('ascii')
        with self._lock:
            try:
                if not self._file.closed:
                    self._file.write(f'{now} {side}> {text}\n')
            except OSError as error:
                self.failure = str(error)
                self._file.close()

    def close(self) -> None:
        """Closes the file."""
        with self._lock:
            self._file.close()
