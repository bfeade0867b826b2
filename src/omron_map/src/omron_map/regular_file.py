"""Opens files whose paths come from another program; reading never blocks.

Only regular files are opened, directly or through links. A pipe would block the reader for ever, a
device can deliver data without end, and opening some devices has side effects.
"""
from __future__ import annotations

import os
import stat
from typing import Callable, Optional, Union

from omron_map.errors import MapError

MAX_BYTES = 32 * 2**20  # largest size of a map; the largest known map of a real robot has 1.3 MB
HEAD_BYTES = 65_536  # the beginning of a file that is checked before the rest is read

_KINDS = (
    (stat.S_ISDIR, 'a folder'), (stat.S_ISFIFO, 'a pipe'), (stat.S_ISSOCK, 'a socket'),
    (stat.S_ISCHR, 'a device'), (stat.S_ISBLK, 'a device'),
)


def read_regular_file(path: Union[str, os.PathLike[str]], accept: Callable[[bytes], object],
                      limit: int = MAX_BYTES) -> bytes:
    """Returns all bytes of the file `path`, without blocking; raises MapError.

    accept -- receives the first HEAD_BYTES, and raises MapError for a file of another kind; the
              rest of such a file is not read
    limit  -- largest size of the file, bytes
    """
    name = os.fspath(path)
    _check(name, status_or_error(name), limit)  # a device must not even be opened
    try:
        # A pipe may have replaced the file since the check: opening must not wait for a writer.
        with open(os.open(name, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), 'rb') as file:
            _check(name, os.fstat(file.fileno()), limit)
            accept(file.read(HEAD_BYTES))
            file.seek(0)
            data = file.read(min(os.fstat(file.fileno()).st_size, limit) + 1)
    except OSError as error:
        raise MapError(name, f'it cannot be read ({error.strerror})') from error
    if len(data) > limit:
        raise _too_large(name, limit)
    return data


def status_of(path: str) -> Optional[os.stat_result]:
    """Returns the status of the file `path`, following links; None if there is no such file."""
    try:
        return os.stat(path)
    except (OSError, ValueError):
        return None


def status_or_error(name: str) -> os.stat_result:
    """Returns the status of the file `name`; raises MapError if there is no such file."""
    try:
        return os.stat(name)
    except OSError as error:
        raise MapError(name, f'it cannot be read ({error.strerror})') from error
    except ValueError as error:  # a zero byte, or characters that the file system does not have
        raise MapError(name, 'no file can have this name') from error


def _check(name: str, status: os.stat_result, limit: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = next((kind for is_kind, kind in _KINDS if is_kind(status.st_mode)), 'no file')
        raise MapError(name, f'it is {kind}', expected='a regular file')
    if status.st_size > limit:
        raise _too_large(name, limit)


def _too_large(name: str, limit: int) -> MapError:
    return MapError(name, 'it is too large for a map', expected=f'at most {limit // 2**20} MiB')
