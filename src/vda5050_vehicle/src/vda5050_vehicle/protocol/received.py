"""Messages that were acted upon, so that a copy that comes late is known as one.

A broker, a bridge between brokers or a master's retry may deliver the same bytes twice, long after
what they asked for was done. Such a copy has the `headerId` and `timestamp` of the first; a master
that wants the same again sends a message of its own.
"""
from __future__ import annotations

from collections import deque
from hashlib import blake2b
from typing import Deque, Iterable, Tuple

REMEMBERED = 200  # messages, of all topics


class ReceivedMessages:
    """Remembers the newest messages by a digest of their bytes."""

    def __init__(self, digests: Iterable[str] = ()) -> None:
        self._digests: Deque[str] = deque(digests, maxlen=REMEMBERED)

    def __contains__(self, payload: bytes) -> bool:
        return _digest(payload) in self._digests

    def add(self, payload: bytes) -> None:
        """This message is acted upon."""
        self._digests.append(_digest(payload))

    @property
    def digests(self) -> Tuple[str, ...]:
        """What a restarted vehicle must know, oldest first."""
        return tuple(self._digests)


def _digest(payload: bytes) -> str:
    return blake2b(payload, digest_size=8).hexdigest()
