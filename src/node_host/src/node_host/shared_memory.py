"""Keeps memory that forks share apart from what each of them writes.

Python and the C library give out what is free between the objects that the host has made. A fork
that writes there copies the whole page, with all that it shares on it. So the host fills these
holes before the first fork, and a fork gives back what its start has used once and never again.
"""
from __future__ import annotations

import ctypes
import gc
import sys
from typing import List

LARGEST = 512  # bytes; Python leaves larger objects to the C library
STEP = 16  # bytes between two of the sizes that Python keeps apart
SMALL = 64  # bytes; holes of up to this size are many
SMALL_HOLES, HOLES = 4000, 500  # of each size, more than there are in a host of all our nodes
_BYTES_ITSELF = sys.getsizeof(b'')  # what `bytes` take beside their content
_LIBC = ctypes.CDLL(None)
_FILLER: List[object] = []


def fill_holes() -> None:
    """Objects lie in the holes from now on."""
    _FILLER.extend(object() for _ in range(SMALL_HOLES))  # 16 bytes
    _FILLER.extend(map(float, range(SMALL_HOLES)))  # 24, which takes 32
    for size in range(3 * STEP, LARGEST + 1, STEP):
        _FILLER.extend(bytes(size - _BYTES_ITSELF)
                       for _ in range(SMALL_HOLES if size <= SMALL else HOLES))


def give_back() -> None:
    """What the start of a program has used and left."""
    gc.collect()
    _LIBC.malloc_trim(0)
