"""Files of the adapter: the journal and log reports. A file is replaced whole or not."""
from __future__ import annotations

import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, Optional, Sequence

import rospy

from node_lifecycle import ConfigurationError

MAX_REPORTS = 20
MAX_JOURNAL = 10_000_000  # bytes


def replace_file(path: Path, text: str) -> None:
    """Writes `path`, for this user only, in one step; raises OSError."""
    handle, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=str(path.parent))
    try:
        with os.fdopen(handle, 'w', encoding='utf-8') as file:
            file.write(text)
        os.replace(name, str(path))
    except BaseException:
        os.unlink(name)
        raise


class JournalFile:
    """Where the vehicle's record is kept over a restart.

    It is not forced to the disk: it must outlive this process, not the computer, after whose
    restart nobody drives the order's route any more.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(f'the folder of the journal {path} cannot be made: '
                                     f'{error.strerror}') from None

    def read(self) -> Optional[Dict[str, Any]]:
        """The record; None where there is none, or none that can be read."""
        try:
            if self._path.stat().st_size > MAX_JOURNAL:
                raise ValueError('it is too large')
            record = json.loads(self._path.read_text(encoding='utf-8'))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, RecursionError) as error:
            rospy.logwarn('The journal %s cannot be read, the vehicle begins without an order: %s',
                          self._path, error)
            return None
        return record if isinstance(record, dict) else None

    def write(self, record: Dict[str, Any]) -> None:
        """Replaces the record; raises OSError."""
        replace_file(self._path, json.dumps(record))


class LogReports:
    """A folder of log reports, the newest twenty."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def write(self, reason: str, lines: Sequence[str]) -> str:
        """Stores a report and returns its file name; raises OSError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        name = time.strftime('report_%Y%m%d_%H%M%S') + f'_{time.time_ns() % 1_000_000_000:09d}.log'
        replace_file(self._folder / name, '\n'.join([f'reason: {reason}', *lines, '']))
        for old in sorted(self._folder.glob('report_*.log'))[:-MAX_REPORTS]:
            old.unlink()
        return name
