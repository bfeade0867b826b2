"""Replaces a file by a complete new one, or leaves it unchanged."""
from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
import stat
from typing import Optional, Union

__all__ = ['replace_file']

_NEW = 0o666  # mode of a new file, before the umask of the process


def replace_file(path: Union[str, os.PathLike], content: Union[str, bytes], *,
                 mode: Optional[int] = None, on_disk: bool = True,
                 backup: Union[str, os.PathLike, None] = None,
                 only_with: bytes = b'') -> None:
    """Writes a file so that at every moment either the old file or the whole new one exists.

    The content is written to a temporary file in the same folder, which then takes the file's name.
    A symbolic link stays, and the file to which it points is replaced. Text is written as UTF-8.
    Raises OSError; the old file is then unchanged.

    mode    -- mode of the new file; None: the mode of the old file, or the default of a new file
    on_disk -- True: the new file survives a power cut. False: it only survives its process, and
               the caller does not wait for the disk
    backup  -- path at which the old file is kept
    only_with -- a mark that the caller writes into each of its files, within the first 4096 bytes.
               Raises FileExistsError if the old file does not have the mark. It is meant for files
               whose names the user did not give
    """
    target = os.path.realpath(path)
    if only_with and not _has(target, only_with):
        raise FileExistsError(errno.EEXIST, 'this file was not written by this program', path)
    folder, name = os.path.split(target)
    temporary = os.path.join(folder, f'.{name[:40]}.{secrets.token_hex(8)}.part')
    if mode is None:
        with contextlib.suppress(FileNotFoundError):
            mode = stat.S_IMODE(os.stat(target).st_mode)
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC,
                     _NEW if mode is None else mode)
    try:
        with os.fdopen(handle, 'wb') as file:
            file.write(content.encode('utf-8') if isinstance(content, str) else content)
            if mode is not None:
                os.fchmod(file.fileno(), mode)
            file.flush()
            if on_disk:
                os.fsync(file.fileno())
        if backup is not None and os.path.exists(target):
            shutil.copy2(target, backup)
        os.replace(temporary, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise
    if on_disk:
        _sync_folder(folder)


def _has(path: str, mark: bytes) -> bool:
    """Returns whether the file has this mark, or does not exist."""
    try:
        with open(path, 'rb') as file:
            return mark in file.read(4096)
    except FileNotFoundError:
        return True


def _sync_folder(folder: str) -> None:
    """Writes the folder to the disk; without this a power cut may bring the old file back."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
