"""Copies a journal while it is in use, and makes an old copy the journal again."""
from __future__ import annotations

import os
import sqlite3
import time
from contextlib import closing
from typing import Callable
from urllib.parse import quote

from fleet_core.supervision.journal import OPEN_STATES
from fleet_core.supervision.journal_database import JournalDatabase
from fleet_core.supervision.missions import MissionState

REASON = 'the journal was restored from a backup'


def copy_database(path: str, copy: str) -> None:
    """Copies an SQLite file in its state at one moment, even while a program writes to it.

    Raises sqlite3.Error.
    """
    address = f'file:{quote(os.path.abspath(path))}?mode=ro'
    with closing(sqlite3.connect(address, uri=True, timeout=5.0)) as source, \
            closing(sqlite3.connect(copy)) as target:
        source.backup(target)


def make_as_lost(path: str, clock: Callable[[], float] = time.time) -> int:
    """Removes everything that may be outdated from an old journal, and cancels its open missions.

    Robots and missions went on after the copy was made. So the fleet manager must begin as after
    the loss of the journal: without robots, routes and open missions. Then the robots report where
    they are. The history stays. Returns how many missions were cancelled. Raises JournalError.
    """
    file = JournalDatabase(path)
    try:
        with file.transaction() as database:
            serials = [row[0] for row in database.execute(
                f'SELECT serial FROM mission WHERE state IN {OPEN_STATES}')]
            now = clock()
            for serial in serials:
                database.execute(
                    "UPDATE mission SET state = ?, reason = ?, changed = ? WHERE serial = ?",
                    (int(MissionState.CANCELLED), REASON, now, serial))
                database.execute(
                    "INSERT INTO change SELECT ?, serial, state, robot, reached, reason, '' "
                    'FROM mission WHERE serial = ?', (now, serial))
            for table in ('robot', 'graph', 'stay', 'value', 'claim'):
                database.execute(f'DELETE FROM {table}')
    finally:
        file.close()
    return len(serials)
