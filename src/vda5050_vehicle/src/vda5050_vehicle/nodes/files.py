"""Files of the adapter: the journal and log reports."""
from __future__ import annotations

import time
from pathlib import Path
from typing import Optional, Sequence, Tuple, Type

from file_replacement import replace_file
from node_lifecycle import ConfigurationError
from node_lifecycle.boot import boot_id
from vda5050_vehicle.core import journal
from vda5050_vehicle.core.state import VdaVehicleState
from vda5050_vehicle.drivers.driver import DriveProgress

MAX_REPORTS = 20
_PRIVATE = 0o600  # for this user only
MAX_JOURNAL = 1_000_000  # bytes of changes after which a new journal is written


class JournalLog:
    """The file that keeps the vehicle's state during a restart, as a log of changes.

    Writing does not force the data to the disk. So the file survives a restart of this process, but
    after a restart of the computer its newest changes may be missing.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        # bytes after the first line; begins at the limit, so that each run writes a new file
        self._changes = MAX_JOURNAL
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(f'the folder of the journal {path} cannot be created: '
                                     f'{error.strerror}') from None

    def read(self, drive: Type[DriveProgress]) -> Optional[Tuple[VdaVehicleState, bool]]:
        """Returns the stored state, or None if there is no file; raises WrongRecord.

        The second value is true if the computer was not booted since the state was stored. An
        unfinished last line is ignored: the vehicle had not yet acted upon its change.
        """
        try:
            *lines, _unfinished = self._path.read_text(encoding='utf-8').split('\n')
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise journal.WrongRecord(str(error)) from None
        if not lines:
            return None
        return journal.read(lines, drive), journal.boot_of(lines[0]) == boot_id()

    def write(self, before: Optional[VdaVehicleState], now: VdaVehicleState) -> None:
        """Appends the changes; writes a new file if the old one is too large. Raises OSError."""
        is_new = before is None or self._changes >= MAX_JOURNAL
        text = journal.line(None if is_new else before, now, boot_id() if is_new else '') + '\n'
        changes, self._changes = self._changes, MAX_JOURNAL  # a new journal after a failure
        if is_new:
            replace_file(self._path, text, mode=_PRIVATE, on_disk=False)
            self._changes = 0
        else:
            with open(self._path, 'a', encoding='utf-8') as file:
                file.write(text)
            self._changes = changes + len(text)


class LogReports:
    """A folder with the newest twenty log reports."""

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
