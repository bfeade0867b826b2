"""A limit on the rate of requests: a bucket of tickets that fills at a constant rate."""
from __future__ import annotations

from typing import Dict, Hashable, Tuple

MOST_KEYS = 2000


class RateLimit:
    """A limit for each key: at most `at_once` tickets, and `each_second` new tickets per second."""

    def __init__(self, at_once: float, each_second: float) -> None:
        self._at_once, self._each_second = at_once, each_second
        self._buckets: Dict[Hashable, Tuple[float, float]] = {}  # tickets left, and when counted

    def allows(self, key: Hashable, now: float) -> bool:
        """Takes a ticket. Returns False if there is none left."""
        left, since = self._buckets.pop(key, (self._at_once, now))
        left = min(self._at_once, left + (now - since) * self._each_second)
        allowed = left >= 1.0
        self._buckets[key] = (left - 1.0 if allowed else left, now)
        if len(self._buckets) > MOST_KEYS:
            del self._buckets[next(iter(self._buckets))]
        return allowed
