"""Messages that were acted upon, so that a copy that comes late is known as one.

A broker, a bridge between brokers or a master's retry may deliver the same bytes twice, long after
what they asked for was done. Such a copy has the `headerId` and `timestamp` of the first; a master
that wants the same again sends a message of its own.
"""
from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b
from typing import Tuple

REMEMBERED = 200  # messages, of all topics


@dataclass(frozen=True)
class ReceivedMessages:
    """Remembers the newest messages by a digest of their bytes, oldest first."""

    digests: Tuple[str, ...] = ()

    def __contains__(self, payload: bytes) -> bool:
        return digest(payload) in self.digests

    def with_message(self, payload: bytes) -> ReceivedMessages:
        """With a message that is acted upon."""
        return ReceivedMessages((*self.digests, digest(payload))[-REMEMBERED:])


def digest(payload: bytes) -> str:
    """A short name of these bytes."""
    return blake2b(payload, digest_size=8).hexdigest()
