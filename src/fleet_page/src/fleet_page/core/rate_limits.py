"""How often a client may ask: a bucket of tickets that fills again steadily."""
from __future__ import annotations

from typing import Dict, Hashable, Tuple

MOST_KEYS = 2000


class RateLimit:
    """So many tickets at once, and so many more each second, for each key."""

    def __init__(self, at_once: float, each_second: float) -> None:
        self._at_once, self._each_second = at_once, each_second
        self._buckets: Dict[Hashable, Tuple[float, float]] = {}  # tickets left, and when

    def allows(self, key: Hashable, now: float) -> bool:
        """Takes a ticket; False: none is left."""
        left, since = self._buckets.pop(key, (self._at_once, now))
        left = min(self._at_once, left + (now - since) * self._each_second)
        allowed = left >= 1.0
        self._buckets[key] = (left - 1.0 if allowed else left, now)
        if len(self._buckets) > MOST_KEYS:
            del self._buckets[next(iter(self._buckets))]
        return allowed
