"""Separates the memory that forks only read from the memory that they write.

Python and the C library put new objects into the holes between the objects of the host. If a fork
writes into a hole, the kernel copies the whole page, with all shared data on the page. So the host
fills these holes before the first fork. A fork also returns the memory that only its start needed.
"""
from __future__ import annotations

import ctypes
import gc
import sys
from typing import List

LARGEST = 512  # bytes; Python leaves larger objects to the C library
STEP = 16  # bytes between two size classes of Python
SMALL = 64  # bytes; there are many holes of up to this size
SMALL_HOLES, HOLES = 4000, 500  # per size class; a host of all our nodes has fewer holes
_BYTES_ITSELF = sys.getsizeof(b'')  # size of a `bytes` without content
_LIBC = ctypes.CDLL(None)
_FILLER: List[object] = []


def fill_holes() -> None:
    """Fills the holes with objects."""
    _FILLER.extend(object() for _ in range(SMALL_HOLES))  # 16 bytes
    _FILLER.extend(map(float, range(SMALL_HOLES)))  # 24 bytes, which take 32
    for size in range(3 * STEP, LARGEST + 1, STEP):
        _FILLER.extend(bytes(size - _BYTES_ITSELF)
                       for _ in range(SMALL_HOLES if size <= SMALL else HOLES))


def give_back() -> None:
    """Returns to the system the memory that the start of a program has used and freed."""
    gc.collect()
    _LIBC.malloc_trim(0)
