"""The request that `hosted` sends for a start: one packet, in the form that hosted.c writes."""
from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Dict, Tuple

LOG_REMAPPING = '__log:='


class BadRequest(ValueError):
    """The packet does not come from a `hosted`."""


@dataclass(frozen=True)
class StartRequest:
    """A program with its arguments, its folder and its environment."""

    folder: str
    arguments: Tuple[str, ...]
    environment: Dict[str, str]

    @property
    def identity(self) -> Tuple[str, ...]:
        """A value that is equal for all starts of one node. It omits the log file, which is new
        each time.
        """
        return (self.environment.get('ROS_NAMESPACE', ''),
                *(one for one in self.arguments if not one.startswith(LOG_REMAPPING)))


def read_request(packet: bytes) -> StartRequest:
    """Returns the request in a packet; raises BadRequest."""
    if not packet.endswith(b'\0'):
        raise BadRequest('The packet has no end.')
    texts = [os.fsdecode(text) for text in packet[:-1].split(b'\0')]
    if len(texts) < 3 or not texts[1].isdigit():
        raise BadRequest('The packet names no program.')
    end = 2 + int(texts[1])
    arguments, environment = texts[2:end], texts[end:]
    if len(texts) < end or not arguments or not arguments[0]:
        raise BadRequest('The packet names no program.')
    pairs = [text.partition('=') for text in environment]
    return StartRequest(texts[0], tuple(arguments), {name: value for name, _, value in pairs})
