"""The SQLite file of a journal: its layout, the migration of older layouts, and its lock."""
from __future__ import annotations

import fcntl
import os
import sqlite3
from contextlib import contextmanager, suppress
from typing import Dict, Iterator, NamedTuple, Optional, Set, Tuple

_BUSY = 0.5  # s to wait if another program holds the file
_VERSION_0_2 = '''
CREATE TABLE IF NOT EXISTS mission (
    serial INTEGER PRIMARY KEY, request_id INTEGER NOT NULL, request TEXT NOT NULL,
    state INTEGER NOT NULL, robot TEXT NOT NULL, reached INTEGER NOT NULL, reason TEXT NOT NULL);
CREATE INDEX IF NOT EXISTS mission_by_id ON mission (request_id);
CREATE INDEX IF NOT EXISTS mission_by_state ON mission (state);
CREATE TABLE IF NOT EXISTS change (
    time REAL NOT NULL, serial INTEGER NOT NULL, state INTEGER NOT NULL, robot TEXT NOT NULL,
    reached INTEGER NOT NULL, reason TEXT NOT NULL);
CREATE INDEX IF NOT EXISTS change_by_serial ON change (serial);
CREATE TABLE IF NOT EXISTS robot (name TEXT PRIMARY KEY, memory TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS value (name TEXT PRIMARY KEY, number INTEGER NOT NULL);
'''
_MIGRATIONS: Tuple[str, ...] = (
    _VERSION_0_2 + '''
    CREATE TABLE IF NOT EXISTS stay (serial INTEGER PRIMARY KEY, began REAL NOT NULL);
    CREATE TABLE IF NOT EXISTS graph (
        one INTEGER PRIMARY KEY CHECK (one = 1), elements TEXT NOT NULL);
    ''', '''
    ALTER TABLE mission ADD COLUMN stamp REAL NOT NULL DEFAULT 0.0;
    ALTER TABLE mission ADD COLUMN changed REAL NOT NULL DEFAULT 0.0;
    UPDATE mission SET stamp = json_extract(request, '$[6]'), changed = coalesce(
        (SELECT MAX(time) FROM change WHERE change.serial = mission.serial), 0.0);
    DROP INDEX mission_by_id;
    CREATE INDEX mission_by_request ON mission (request_id, stamp);
    CREATE INDEX mission_by_change ON mission (changed);
    ''', '''
    ALTER TABLE change ADD COLUMN requested_by TEXT NOT NULL DEFAULT '';
    ''', '''
    CREATE TABLE stop (one INTEGER PRIMARY KEY CHECK (one = 1), record TEXT NOT NULL);
    INSERT INTO stop SELECT 1, '{"cause": 4, "by": "", "since": 0.0, "why": ""}' FROM value
        WHERE name = 'fleet_is_stopped' AND number <> 0;
    DELETE FROM value WHERE name = 'fleet_is_stopped';
    ''', '''
    CREATE TABLE IF NOT EXISTS work (serial INTEGER PRIMARY KEY, work TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS load (robot TEXT PRIMARY KEY, load TEXT NOT NULL);
    ''', '''
    CREATE TABLE claim (
        robot TEXT NOT NULL, resource TEXT NOT NULL, PRIMARY KEY (robot, resource));
    ''', '''
    ALTER TABLE mission ADD COLUMN deadline_state INTEGER NOT NULL DEFAULT 0;
    ''')
"""Statement k turns a file of version k into one of version k + 1. A new file has version 0."""
LAYOUT: Dict[str, Tuple[str, ...]] = {
    'mission': ('serial', 'request_id', 'request', 'state', 'robot', 'reached', 'reason', 'stamp',
                'changed', 'deadline_state'),
    'change': ('time', 'serial', 'state', 'robot', 'reached', 'reason', 'requested_by'),
    'stay': ('serial', 'began'), 'robot': ('name', 'memory'), 'value': ('name', 'number'),
    'graph': ('one', 'elements'), 'stop': ('one', 'record'), 'work': ('serial', 'work'),
    'load': ('robot', 'load'), 'claim': ('robot', 'resource')}
"""The columns of each table of the newest version."""


class JournalError(Exception):
    """The journal cannot be used. The text is one sentence that says what to do."""


class NoJournal(JournalError):
    """There is no file: no mission was ever accepted, or the file is kept elsewhere."""


class UnknownLayout(JournalError):
    """The file is a database, but not a journal that this version can read."""

    def __init__(self, path: str, what: str) -> None:
        super().__init__(f'The journal {os.path.abspath(path)} cannot be used: {what}. Choose '
                         'another file with ~journal, or use the version that wrote this one.')


class JournalUnavailable(JournalError):
    """The journal cannot be used now, but perhaps later: the disk is full or not writable.

    reason -- the text of the exception, as a clause
    """

    def __init__(self, path: str, what: object, remedy: str = 'free space on its disk, or mend that'
                 ) -> None:
        self.reason = (f'the journal {os.path.abspath(path)} cannot be written ({what}): {remedy}')
        super().__init__(f'{self.reason[0].upper()}{self.reason[1:]}.')


class _Identity(NamedTuple):
    """The identity of a file, and its first 100 bytes, in which SQLite counts changes."""

    device: int
    inode: int
    head: bytes = b''


class JournalDatabase:
    """The file, open and locked for one supervisor.

    Raises JournalError, and JournalUnavailable if the file cannot be used now, for example because
    another supervisor uses it.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._lock = _locked(path)
        self._head: Optional[int] = None
        try:
            self.database = sqlite3.connect(path, isolation_level=None, timeout=_BUSY,
                                            check_same_thread=False)
            self.database.execute('PRAGMA journal_mode=WAL')
            self.database.execute('PRAGMA synchronous=FULL')
            _migrate(self.database, path)
            # This descriptor stays open as long as the database: closing it would also end the
            # locks of SQLite.
            self._head = os.open(path, os.O_RDONLY)
            self._expected = self._identities()
        except JournalError:
            self.close()
            raise
        except (sqlite3.OperationalError, OSError) as error:
            self.close()
            raise JournalUnavailable(path, error) from None
        except sqlite3.Error as error:
            self.close()
            raise JournalError(f'The journal {os.path.abspath(path)} cannot be opened ({error}): '
                               'choose another file or mend this one.') from None

    def close(self) -> None:
        """Closes the file."""
        if hasattr(self, 'database'):
            self.database.close()
        for descriptor in (self._head, self._lock):
            if descriptor is not None:
                os.close(descriptor)
        self._head = None

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Yields a transaction: at its end either all of its changes are on the disk, or none.

        Raises JournalUnavailable, also if the file was deleted or replaced since the last commit.
        Data that were written to the old file would be lost.
        """
        self._check()
        try:
            self.database.execute('BEGIN IMMEDIATE')
            yield self.database
            self.database.execute('COMMIT')
            self._expected = self._identities()
        except (sqlite3.Error, OSError) as error:
            raise JournalUnavailable(self._path, error) from None
        finally:
            with suppress(sqlite3.Error):  # if even that fails, the next BEGIN fails, too
                if self.database.in_transaction:
                    self.database.execute('ROLLBACK')

    def _check(self) -> None:
        try:
            identities = self._identities()
        except OSError as error:
            raise self._replaced(str(error)) from None
        if identities != self._expected:
            raise self._replaced('another program has replaced or overwritten it')

    def _replaced(self, what: str) -> JournalUnavailable:
        return JournalUnavailable(self._path, what, 'put the file back, or end path_supervisor, '
                                                    'which then begins as with a lost journal')

    def _identities(self) -> Tuple[_Identity, ...]:
        """Returns the identities of the database, and of the log with its last commits."""
        assert self._head is not None
        found = os.stat(self._path)
        log = self._path + '-wal'
        identities = [_Identity(found.st_dev, found.st_ino, os.pread(self._head, 100, 0))]
        if os.path.exists(log):
            found = os.stat(log)
            identities.append(_Identity(found.st_dev, found.st_ino))
        return tuple(identities)


def _locked(path: str) -> int:
    """Locks a file beside the journal, because SQLite itself locks the journal file.

    Returns the descriptor of the file.
    """
    try:
        lock = os.open(f'{path}.lock', os.O_RDWR | os.O_CREAT, 0o600)
    except OSError as error:
        raise JournalUnavailable(path, error.strerror) from None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        raise JournalUnavailable(path, 'another path_supervisor uses it', 'end that one, or give '
                                 'this one a file of its own with ~journal') from None
    return lock


def _migrate(database: sqlite3.Connection, path: str) -> None:
    """Migrates a file to the newest version, or leaves it unchanged and raises an error."""
    version = int(database.execute('PRAGMA user_version').fetchone()[0])
    if version > len(_MIGRATIONS):
        raise UnknownLayout(path, f'it has version {version}, newer than {len(_MIGRATIONS)}')
    for number in range(version, len(_MIGRATIONS)):
        try:
            database.executescript(f'BEGIN IMMEDIATE;{_MIGRATIONS[number]};'
                                   f'PRAGMA user_version = {number + 1};COMMIT')
        except sqlite3.OperationalError as error:
            if database.in_transaction:
                database.execute('ROLLBACK')
            if number == version and _columns(database, 'mission') - set(LAYOUT['mission']):
                raise UnknownLayout(path, str(error)) from None
            raise
    for table, columns in LAYOUT.items():
        found = _columns(database, table)
        if found != set(columns):
            wrong = ', '.join(sorted(found ^ set(columns)))
            raise UnknownLayout(path, f'table {table} has other columns ({wrong})')


def _columns(database: sqlite3.Connection, table: str) -> Set[str]:
    return {row[1] for row in database.execute(f'PRAGMA table_info({table})')}
