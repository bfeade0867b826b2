"""Cancellations and modifications that REST clients have posted and the server has carried out.

Such a record is stored together with the jobs that it changes. So after a restart a client can
still query whether the record was carried out, and a second record with the same key is refused.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

MOST_POSTED = 1000  # the newest records of each type are kept


@dataclass(frozen=True)
class PostedRecord:
    """One posted record.

    kind   -- the name of its type in paths
    number -- grows by one with each record of its type, also across restarts
    at     -- ms since 1970
    record -- its fields as clients see them, without its times
    """

    kind: str
    number: int
    at: int
    record: Mapping[str, Any]
