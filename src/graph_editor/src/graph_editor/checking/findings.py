"""Findings: problems of a graph with their place and severity."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Iterable, List, Optional, Tuple


class Severity(Enum):
    """The severity of a finding."""

    ERROR = 'error'
    """Robots cannot drive on the present graph, or the loader refuses the graph."""
    WARNING = 'warning'
    """The graph can be used, but a person should know the problem."""


@dataclass(frozen=True)
class Finding:
    """One problem.

    kind -- 'vertex', 'edge', 'place' (of the map), or '' if the problem concerns no single element
    id   -- id of the vertex or edge, else None
    """

    severity: Severity
    text: str
    """A clause, e.g. `a wall is 0.21 m from it, but the robot needs 0.25 m`."""
    kind: str = ''
    id: Optional[int] = None
    place: Optional[Tuple[float, float]] = None
    """The position of the problem: x, y in m."""

    def __str__(self) -> str:
        about = f'{self.kind} {self.id}: ' if self.id is not None else ''
        where = '' if self.place is None else f' (at {self.place[0]:.2f} {self.place[1]:.2f})'
        return f'{self.severity.value}: {about}{self.text}{where}'


def in_order(findings: Iterable[Finding]) -> List[Finding]:
    """Returns the findings sorted: errors first, then by kind, id, text and place."""
    return sorted(findings, key=lambda finding: (
        finding.severity is Severity.WARNING, finding.kind, finding.id or 0, finding.text,
        finding.place or (0.0, 0.0)))
