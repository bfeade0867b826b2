"""Writes files in one step, so that a reader never finds an incomplete file."""
from __future__ import annotations

import os

from PIL.PngImagePlugin import PngInfo

from file_replacement import replace_file
from omron_map.errors import MapError

MADE_BY = 'written by ld_map'  # in each file whose name the program may choose


def write_file(path: str, data: bytes, backup: bool = False, is_named: bool = True) -> None:
    """Replaces a file; with `backup` the old file stays as `<path>.bak`. Raises MapError.

    is_named -- whether the user gave the name; if not, an existing file is replaced only if ld_map
                wrote it
    """
    try:
        replace_file(path, data, backup=f'{os.path.realpath(path)}.bak' if backup else None,
                     only_with=b'' if is_named else MADE_BY.encode())
    except FileExistsError:
        raise MapError(path, 'it was not written by ld_map and is not overwritten: name another '
                       'OUTPUT, or remove the file') from None
    except OSError as error:
        raise MapError(path, f'it cannot be written ({error.strerror})') from error


def png_notes() -> PngInfo:
    """Returns the text chunk of a PNG file that names its writer."""
    notes = PngInfo()
    notes.add_text('Software', MADE_BY)
    return notes
