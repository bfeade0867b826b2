"""Plans: what robots are to drive, and when."""
from __future__ import annotations

from typing import Dict, List, Mapping, NamedTuple, Sequence, Tuple


class Drive(NamedTuple):
    """One edge in one direction, driven from `start` to `end`, in s from the plan's beginning."""

    drive: int
    start: float
    end: float
    begun: float = 0.0
    """Fraction of the edge that is behind the robot at `start`; above 0 only in a plan's first
    drive.
    """


Plan = List[Drive]
"""The drives of one robot in order. It may wait between two drives, and stays after the last one.
"""

Plans = Dict[str, Plan]
"""The plan of each robot by name."""


Arrival = Tuple[int, float, int, float]
"""A drive, when it begins, the vertex at its end, and when the robot arrives there."""


def end_of(plan: Sequence[Drive]) -> float:
    """Returns when the robot has come to rest: the end of its last drive; 0: it never drives."""
    return plan[-1].end if plan else 0.0


def sum_of_costs(plans: Mapping[str, Sequence[Drive]]) -> float:
    """Returns the sum of the ends of all robots."""
    return sum(map(end_of, plans.values()))


def makespan(plans: Mapping[str, Sequence[Drive]]) -> float:
    """Returns the end of the last drive of all robots."""
    return max(map(end_of, plans.values()), default=0.0)
