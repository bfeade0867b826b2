"""Headers of outgoing messages: each topic has its own count of ids; timestamps never go back."""
from __future__ import annotations

from collections import Counter
from datetime import datetime, timezone
from typing import Callable
from typing import Counter as Counts

from vda5050_protocol.fields import UINT32
from vda5050_protocol.values import Header


def timestamp(seconds: float) -> str:
    """Returns the time in ISO 8601, UTC, with milliseconds, as the standard requires."""
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return f'{moment:%Y-%m-%dT%H:%M:%S}.{moment.microsecond // 1000:03d}Z'


class Headers:
    """Makes the headers of one sender; `clock` returns the seconds since 1970.

    A master drops a state that is older than the state before it. So if the clock is set back,
    each timestamp is one millisecond later than the previous one until the clock has caught up.
    """

    def __init__(self, version: str, manufacturer: str, serial_number: str,
                 clock: Callable[[], float]) -> None:
        self._identity = (version, manufacturer, serial_number)
        self._clock = clock
        self._sent: Counts[str] = Counter()
        self._latest = 0.0

    def make(self, topic: str) -> Header:
        """Returns the header of the next message on `topic`."""
        self._latest = max(self._clock(), self._latest + 0.001)
        header_id = self._sent[topic] & UINT32
        self._sent[topic] += 1
        return Header(header_id, timestamp(self._latest), *self._identity)

    def last(self, topic: str) -> int:
        """Returns the id of the last message on `topic`; 0 before the first message."""
        return max(self._sent[topic] - 1, 0) & UINT32
