"""Remembers the messages that the vehicle has acted upon, so that it recognises a late copy.

A broker, a bridge between brokers or a retry of the master may deliver the same bytes twice, even
long after the vehicle has executed the first message. A copy has the same `headerId` and
`timestamp`. A master that wants the same thing again sends a message with a new header.
"""
from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b
from typing import Tuple

REMEMBERED = 200  # number of messages, over all topics


@dataclass(frozen=True)
class ReceivedMessages:
    """The newest messages: a digest of the bytes of each one, oldest first."""

    digests: Tuple[str, ...] = ()

    def __contains__(self, payload: bytes) -> bool:
        return digest(payload) in self.digests

    def with_message(self, payload: bytes) -> ReceivedMessages:
        """Returns the record with a message that the vehicle acts upon."""
        return ReceivedMessages((*self.digests, digest(payload))[-REMEMBERED:])


def digest(payload: bytes) -> str:
    """Returns a short digest of these bytes."""
    return blake2b(payload, digest_size=8).hexdigest()
