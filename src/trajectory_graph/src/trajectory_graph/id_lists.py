"""Lists of ids in sentences for people; the lists are short, so that they do not fill a log."""
from __future__ import annotations

from typing import Collection

MOST = 20
"""Largest number of ids that a sentence names."""


def listed(ids: Collection[int], most: int = MOST) -> str:
    """Returns e.g. `3, 4 and 7 more`: the first `most` ids, then the number of the others."""
    named = ', '.join(str(id) for _, id in zip(range(most), ids))
    return f'{named} and {len(ids) - most} more' if len(ids) > most else named
