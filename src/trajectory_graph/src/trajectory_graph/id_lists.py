"""Lists of ids in sentences for people: logs, reasons and messages contain few of them."""
from __future__ import annotations

from typing import Collection

MOST = 20
"""Number of ids that a sentence names, so that a long list does not fill a log."""


def listed(ids: Collection[int], most: int = MOST) -> str:
    """Returns `3, 4 and 7 more`: at most `most` ids in the given order,
    then the number of the others.
    """
    named = ', '.join(str(id) for _, id in zip(range(most), ids))
    return f'{named} and {len(ids) - most} more' if len(ids) > most else named
