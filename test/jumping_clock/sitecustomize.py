"""Makes the wall clock of a Python process jump: time.time() is ahead by the seconds in a file.

Python imports this module at its start if the module's folder is in PYTHONPATH. JUMPING_CLOCK names
the file, which need not exist. The clock of time.monotonic does not jump.
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
