"""The SQLite file that keeps the jobs across a restart or a power cut."""
from __future__ import annotations

import json
import os
import sqlite3
from typing import List, Optional, Sequence, Tuple

from json_records import from_json, to_json
from node_lifecycle import ConfigurationError
from node_lifecycle.kept_files import hold, in_ros_home
from omron_jobs.core.job_book import JobCounters
from omron_jobs.core.jobs import QueuedJob
from omron_jobs.core.posted_records import MOST_POSTED, PostedRecord

VERSION = 1
_ADDED = ('robot', 'origin', 'swap')  # fields of jobs that older files do not have
_LAYOUT = '''
CREATE TABLE job (mission INTEGER PRIMARY KEY, record TEXT NOT NULL);
CREATE TABLE counters (one INTEGER PRIMARY KEY CHECK (one = 1), record TEXT NOT NULL);
PRAGMA user_version = 1;
'''
# Older files do not have this table, and older programs ignore it. So `user_version` stays 1.
_POSTED = '''
CREATE TABLE IF NOT EXISTS posted (kind TEXT, number INTEGER, record TEXT NOT NULL,
                                   PRIMARY KEY (kind, number))
'''


class JobFile:
    """Keeps jobs and counters; a relative path begins in ROS_HOME."""

    def __init__(self, path: str, parameter: str) -> None:
        """Raises ConfigurationError if the file is not usable, or another process uses it."""
        self._path, self._parameter = in_ros_home(path), parameter
        hold(self._path, parameter)
        try:
            os.makedirs(os.path.dirname(os.path.abspath(self._path)), exist_ok=True)
            self._database = sqlite3.connect(self._path, isolation_level=None,
                                             check_same_thread=False)
            self._database.execute('PRAGMA journal_mode=WAL')
            self._database.execute('PRAGMA synchronous=FULL')
            found, = self._database.execute('PRAGMA user_version').fetchone()
            if found == 0:
                self._database.executescript(f'BEGIN; {_LAYOUT} COMMIT;')
            elif found != VERSION:
                raise self._unusable(f'it has the unknown version {found}')
            self._database.execute(_POSTED)
        except (OSError, sqlite3.Error) as error:
            raise self._unusable(str(error)) from None

    def _unusable(self, problem: str) -> ConfigurationError:
        return ConfigurationError(
            f'The jobs cannot be kept in {self._path} ({problem}): mend it, or give this node '
            f'another one with {self._parameter}. With another file it does not know its jobs.')

    def read(self) -> Tuple[List[QueuedJob], JobCounters]:
        """Returns the stored jobs and counters. Raises ConfigurationError if they cannot be read,
        because jobs would be lost.
        """
        try:
            jobs = [from_json(QueuedJob, json.loads(record), _ADDED) for record, in
                    self._database.execute('SELECT record FROM job')]
            counters = [from_json(JobCounters, json.loads(record)) for record, in
                        self._database.execute('SELECT record FROM counters')]
        except (sqlite3.Error, ValueError, TypeError, RecursionError) as error:
            raise self._unusable(str(error)) from None
        return jobs, counters[0] if counters else JobCounters()

    def read_posted(self) -> List[PostedRecord]:
        """Returns the records that REST clients have posted. Raises ConfigurationError."""
        try:
            return [from_json(PostedRecord, json.loads(record)) for record, in
                    self._database.execute('SELECT record FROM posted ORDER BY number')]
        except (sqlite3.Error, ValueError, TypeError, RecursionError) as error:
            raise self._unusable(str(error)) from None

    def write(self, jobs: Sequence[QueuedJob], forgotten: Sequence[int], counters: JobCounters,
              posted: Optional[PostedRecord] = None) -> None:
        """Stores jobs and counters, forced to the disk: all or nothing. Raises OSError."""
        try:
            self._database.execute('BEGIN IMMEDIATE')
            try:
                self._database.executemany(
                    'INSERT OR REPLACE INTO job VALUES (?, ?)',
                    [(job.mission, json.dumps(to_json(job))) for job in jobs])
                self._database.executemany('DELETE FROM job WHERE mission = ?',
                                           [(id,) for id in forgotten])
                self._database.execute('INSERT OR REPLACE INTO counters VALUES (1, ?)',
                                       (json.dumps(to_json(counters)),))
                if posted is not None:
                    self._database.execute(
                        'INSERT INTO posted VALUES (?, ?, ?)',
                        (posted.kind, posted.number, json.dumps(to_json(posted))))
                    self._database.execute(
                        'DELETE FROM posted WHERE kind = ? AND number <= ?',
                        (posted.kind, posted.number - MOST_POSTED))
                self._database.execute('COMMIT')
            except sqlite3.Error:
                if self._database.in_transaction:
                    self._database.execute('ROLLBACK')
                raise
        except sqlite3.Error as error:
            raise OSError(0, str(error)) from None

    def close(self) -> None:
        """Closes the file."""
        self._database.close()
