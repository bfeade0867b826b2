"""Replaces a file by a complete new one, or not at all."""
from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import stat
from typing import Optional, Union

__all__ = ['replace_file']

_NEW = 0o666  # mode of a new file, of which the process takes its umask away


def replace_file(path: Union[str, os.PathLike], content: Union[str, bytes], *,
                 mode: Optional[int] = None, on_disk: bool = True,
                 backup: Union[str, os.PathLike, None] = None) -> None:
    """Writes a file so that at every moment the old one or the whole new one is there.

    The content goes to a temporary file in the same folder, then takes the file's name. A symbolic
    link stays, and the file it leads to is replaced. Text is written as UTF-8. Raises OSError; the
    old file is untouched then.

    mode    -- of the new file; None: that of the old one, or of any new file
    on_disk -- the new file outlives a power cut. False is for a file that must outlive its process
               only, where nothing may wait for a disk
    backup  -- where the old file is kept
    """
    target = os.path.realpath(path)
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


def _sync_folder(folder: str) -> None:
    """Without it a power cut may bring the old file back."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
