"""The disk of a virtual supervisor: its journal outlives the supervisor, and may be full."""
from __future__ import annotations

import os
import sqlite3
import tempfile
from typing import Any, Callable

from fleet_core.supervision.journal import Journal


class _CountingJournal(Journal):
    """A journal that counts its completed writes."""

    commits = 0

    def store(self, *given: Any, **named: Any) -> None:
        super().store(*given, **named)
        self.commits += 1


class VirtualDisk:
    """Holds the journal of the supervisor that runs now, in a folder that ends with the world.

    clock    -- returns the right time, s since 1970
    set_back -- s by which the clock of the supervisor's computer was set back
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self.set_back = 0.0
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
        """Makes the journal read-only, as on a full disk; with `fails` False, writable again."""
        self.is_full = fails
        self.journal._db.execute(f'PRAGMA query_only={int(fails)}')

    def reopen(self) -> None:
        """Opens the journal again for the next supervisor. It can be written again."""
        self._commits_before = self.commits
        self.journal.close()
        self.journal = self._open()
        self.is_full = False

    def copy(self) -> sqlite3.Connection:
        """Returns a copy of the journal as it is now."""
        copy = sqlite3.connect(':memory:')
        self.journal._db.backup(copy)
        return copy

    def put_back(self, copy: sqlite3.Connection) -> None:
        """Puts a copy in the place of the journal.

        The file beside the journal stays. `reopen` is to be called next.
        """
        self.fails(False)
        copy.backup(self.journal._db)

    def end(self) -> None:
        """Closes and deletes the journal."""
        self.journal.close()
        self._folder.cleanup()

    def _open(self) -> _CountingJournal:
        journal = _CountingJournal(self.journal_path, lambda: self._clock() - self.set_back)
        journal._db.execute('PRAGMA synchronous=OFF')  # no test here cuts the power
        return journal
