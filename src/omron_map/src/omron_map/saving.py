"""Replacing a file by a complete new one, or not at all."""
from __future__ import annotations

import contextlib
import os
import shutil
import tempfile

from omron_map.errors import MapError


def write_file(path: str, data: bytes, backup: bool = False) -> None:
    """Write `data` to `path` so that at every moment the old file or the whole new one is there.

    The data goes to a temporary file beside the target, then to the disk, then takes the target's
    name; mode and a symbolic link are kept. With `backup` the old file stays as `<path>.bak`.
    Raises MapError when the file cannot be written; the old one is untouched then.
    """
    target = os.path.realpath(path)
    folder, name = os.path.split(target)
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(prefix=f'.{name}.', suffix='.tmp', dir=folder)
        with os.fdopen(handle, 'wb') as file:
            file.write(data)
            file.flush()
            os.fchmod(file.fileno(), _mode(target))
            os.fsync(file.fileno())
        if backup and os.path.exists(target):
            shutil.copy2(target, target + '.bak')
        os.replace(temporary, target)
        temporary = None
        _sync_folder(folder)
    except OSError as error:
        raise MapError(path, f'it cannot be written ({error.strerror})') from error
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                os.unlink(temporary)


def _mode(path: str) -> int:
    """The mode of the file to be replaced, or that of any new file."""
    try:
        return os.stat(path).st_mode & 0o777
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask


def _sync_folder(folder: str) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
