"""Files of the adapter: the journal and log reports."""
from __future__ import annotations

import time
from pathlib import Path
from typing import Optional, Sequence, Type

from file_replacement import replace_file
from node_lifecycle import ConfigurationError
from vda5050_vehicle.core import journal
from vda5050_vehicle.core.state import VehicleState
from vda5050_vehicle.drivers.driver import Drive

MAX_REPORTS = 20
_PRIVATE = 0o600  # for this user only
MAX_JOURNAL = 1_000_000  # bytes of changes, beyond which it is written anew


class JournalFile:
    """Where the vehicle's state is kept over a restart, as a log of changes.

    It is not forced to the disk: it must outlive this process, not the computer, after whose
    restart no robot drives the order's route any more.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._changes = MAX_JOURNAL  # bytes behind its first line; each run begins it anew
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(f'the folder of the journal {path} cannot be made: '
                                     f'{error.strerror}') from None

    def read(self, drive: Type[Drive]) -> Optional[VehicleState]:
        """The state; None where there is none. Raises WrongRecord. A line that was not finished is
        of a change about which nothing was done."""
        try:
            *lines, _unfinished = self._path.read_text(encoding='utf-8').split('\n')
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise journal.WrongRecord(str(error)) from None
        return journal.read(lines, drive) if lines else None

    def write(self, before: Optional[VehicleState], now: VehicleState) -> None:
        """Adds what changed; begins anew where that would be too much. Raises OSError."""
        is_new = before is None or self._changes >= MAX_JOURNAL
        text = journal.line(None if is_new else before, now) + '\n'
        changes, self._changes = self._changes, MAX_JOURNAL  # should it fail
        if is_new:
            replace_file(self._path, text, mode=_PRIVATE, on_disk=False)
            self._changes = 0
        else:
            with open(self._path, 'a', encoding='utf-8') as file:
                file.write(text)
            self._changes = changes + len(text)


class LogReports:
    """A folder of log reports, the newest twenty."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def write(self, reason: str, lines: Sequence[str]) -> str:
        """Stores a report and returns its file name; raises OSError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        name = time.strftime('report_%Y%m%d_%H%M%S') + f'_{time.time_ns() % 1_000_000_000:09d}.log'
        replace_file(self._folder / name, '\n'.join([f'reason: {reason}', *lines, '']),
                     mode=_PRIVATE)
        for old in sorted(self._folder.glob('report_*.log'))[:-MAX_REPORTS]:
            old.unlink()
        return name
