"""Writes files in one step, so that a reader never finds an incomplete file."""
from __future__ import annotations

import os

from file_replacement import replace_file
from omron_map.errors import MapError


def write_file(path: str, data: bytes, backup: bool = False) -> None:
    """Replaces a file; with `backup` the old file stays as `<path>.bak`. Raises MapError."""
    try:
        replace_file(path, data, backup=f'{os.path.realpath(path)}.bak' if backup else None)
    except OSError as error:
        raise MapError(path, f'it cannot be written ({error.strerror})') from error
