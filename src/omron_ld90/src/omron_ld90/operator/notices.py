"""What the person at the screen is told."""
from __future__ import annotations

import enum
from dataclasses import dataclass


class Severity(enum.Enum):
    """How good a notice is."""

    INFO = 'info'
    GOOD = 'good'
    BAD = 'bad'


@dataclass(frozen=True)
class Notice:
    """A sentence for people."""

    severity: Severity
    text: str
