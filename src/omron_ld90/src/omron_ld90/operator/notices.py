"""Messages to the person at the screen."""
from __future__ import annotations

import enum
from dataclasses import dataclass


class NoticeSeverity(enum.Enum):
    """Whether a notice is good news, bad news, or neither."""

    INFO = 'info'
    GOOD = 'good'
    BAD = 'bad'


@dataclass(frozen=True)
class OperatorNotice:
    """A sentence for a person."""

    severity: NoticeSeverity
    text: str
