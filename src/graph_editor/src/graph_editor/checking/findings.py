"""Findings: what is wrong, where, and how bad it is."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Iterable, List, Optional, Tuple


class Severity(Enum):
    """How bad a finding is."""

    ERROR = 'error'
    """Robots cannot drive on the graph as it says, or the loader refuses it."""
    WARNING = 'warning'
    """It works, but a person should know."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    kind -- 'vertex', 'edge', 'place' (of the map) or '' where it is nothing of the graph
    id   -- of the vertex or edge, else None
    """

    severity: Severity
    text: str
    """A clause, e.g. `a wall is 0.21 m from it, but the robot needs 0.25 m`."""
    kind: str = ''
    id: Optional[int] = None
    place: Optional[Tuple[float, float]] = None
    """x, y in m, where it is to be seen."""

    def __str__(self) -> str:
        about = f'{self.kind} {self.id}: ' if self.id is not None else ''
        where = '' if self.place is None else f' (at {self.place[0]:.2f} {self.place[1]:.2f})'
        return f'{self.severity.value}: {about}{self.text}{where}'


def in_order(findings: Iterable[Finding]) -> List[Finding]:
    """Errors first, then by what they are about."""
    return sorted(findings, key=lambda finding: (
        finding.severity is Severity.WARNING, finding.kind, finding.id or 0, finding.text,
        finding.place or (0.0, 0.0)))
