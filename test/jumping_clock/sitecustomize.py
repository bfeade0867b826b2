"""The wall clock of a Python process jumps: time.time() is ahead by what stands in a file.

Python imports this by itself from a folder in PYTHONPATH. JUMPING_CLOCK names the file, which may
be missing. Clocks that never jump (time.monotonic) stay as they are.
"""
from __future__ import annotations

import os
import time

_real = time.time
_file = os.environ.get('JUMPING_CLOCK', '')


def _jumped() -> float:
    try:
        with open(_file, encoding='ascii') as file:
            return _real() + float(file.read())
    except FileNotFoundError:
        return _real()


if _file:
    time.time = _jumped
