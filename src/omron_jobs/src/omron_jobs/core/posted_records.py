"""What REST clients have posted and the server has carried out: cancellations, modifications.

Such a record is stored together with what it changes. So after a restart its client can still ask
whether it was carried out, and its key does not count twice.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

MOST_POSTED = 1000  # of each type that are kept: the last ones


@dataclass(frozen=True)
class PostedRecord:
    """One such record.

    kind   -- its type, as its paths name it
    number -- grows by one with each record of its type, over restarts too
    at     -- ms since 1970
    record -- what clients see of it, without its times
    """

    kind: str
    number: int
    at: int
    record: Mapping[str, Any]
