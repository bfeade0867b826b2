"""The disk of a virtual supervisor. It keeps the journal across restarts, and may be full."""
from __future__ import annotations

import os
import sqlite3
import tempfile
from pathlib import Path
from typing import Any, Callable

from fleet_core.supervision.journal import Journal


class _CountingJournal(Journal):
    """A journal that counts its completed writes, and calls `wait` after each of them."""

    def __init__(self, path: str, clock: Callable[[], float], wait: Callable[[], None]) -> None:
        super().__init__(path, clock)
        self.commits, self._wait = 0, wait

    def store(self, *given: Any, **named: Any) -> None:
        super().store(*given, **named)
        self.commits += 1
        self._wait()


class VirtualDisk:
    """Holds the journal of the present supervisor, in a folder that is deleted with the virtual
    world.

    clock    -- returns the right time, s since 1970
    hang     -- lets the given seconds pass, while a write takes long
    set_back -- s; the clock of the supervisor's computer is behind by this time
    seconds  -- s that the next write takes; later writes take no time
    """

    def __init__(self, clock: Callable[[], float], hang: Callable[[float], None]) -> None:
        self._clock, self._hang = clock, hang
        self.set_back = self.seconds = 0.0
        self._folder = tempfile.TemporaryDirectory()
        self.journal_path = os.path.join(self._folder.name, 'journal.sqlite')
        self._commits_before = 0
        self.journal = self._open()
        self.is_full = False

    @property
    def commits(self) -> int:
        """The number of completed writes by all supervisors."""
        return self._commits_before + self.journal.commits

    def fails(self, fails: bool = True) -> None:
        """Makes the journal read-only, as on a full disk. With `fails` False, makes it writable
        again.
        """
        self.is_full = fails
        self.journal._db.execute(f'PRAGMA query_only={int(fails)}')

    def reopen(self) -> None:
        """Opens the journal for the next supervisor. The disk is neither full nor slow any more."""
        self._commits_before = self.commits
        self.journal.close()
        self.journal = self._open()
        self.is_full, self.seconds = False, 0.0

    def replace_file(self, write: Callable[[str], None]) -> None:
        """Replaces the journal by the file that `write` makes at a given path.

        All other files in the folder are deleted. The caller then calls `reopen`.
        """
        self._commits_before = self.commits
        self.journal.close()
        for file in Path(self._folder.name).iterdir():
            file.unlink()
        write(self.journal_path)
        self.journal = self._open()

    def copy(self) -> sqlite3.Connection:
        """Returns a copy of the journal as it is now."""
        copy = sqlite3.connect(':memory:')
        self.journal._db.backup(copy)
        return copy

    def put_back(self, copy: sqlite3.Connection) -> None:
        """Replaces the content of the journal by a copy.

        Other files in the folder stay. The caller then calls `reopen`.
        """
        self.fails(False)
        copy.backup(self.journal._db)

    def end(self) -> None:
        """Closes and deletes the journal."""
        self.journal.close()
        self._folder.cleanup()

    def _wait(self) -> None:
        seconds, self.seconds = self.seconds, 0.0
        if seconds:
            self._hang(seconds)

    def _open(self) -> _CountingJournal:
        journal = _CountingJournal(self.journal_path, lambda: self._clock() - self.set_back,
                                   self._wait)
        journal._db.execute('PRAGMA synchronous=OFF')  # safe, because no test simulates a power cut
        return journal
