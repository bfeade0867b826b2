"""The run number: it shows whether the journal is the one that the last run wrote.

Each start draws a number, and writes it into the journal and into a file beside it. If an older
journal is put back, the two numbers differ.
"""
from __future__ import annotations

import secrets

from fleet_core.supervision.journal import Journal

RUN_NUMBER = 'run_number'
"""Name of the number in the journal."""
_BITS = 62  # so that SQLite can store it as an integer


class RunNumber:
    """The run number of one supervisor.

    The constructor and `draw` raise JournalUnavailable.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self.is_wrong = journal.value(RUN_NUMBER) != journal.number_beside()
        """Whether the two numbers differ. Then stored places of robots may be wrong."""

    def draw(self) -> int:
        """Draws a number and writes it into the file. Returns it: the journal is to store it."""
        number = secrets.randbits(_BITS) + 1
        self._journal.write_beside(number)
        self.is_wrong = False
        return number
