"""What one run of a fleet came to."""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Dict, List, Tuple


class Use(Enum):
    """What a robot's time goes to."""

    LOADED = 'driving with a mission'
    EMPTY = 'driving without one'
    STAY = 'at a destination'
    HELD = 'docking, stalled, or before a person'
    WAITING = 'waiting'
    CHARGING = 'charging'
    IDLE = 'idle'
    OUT = 'out of order'


class Cause(Enum):
    """What a robot waits for."""

    ROBOT = 'another robot'
    PLANNER = 'the planner'
    NO_PLAN = 'no plan serves it'
    CLOSED = 'a closed edge'
    OWN = 'its own start'


@dataclass
class Figures:
    """One run; times in virtual s unless they are `spent`.

    seconds        -- for which was measured, after the warm-up
    waits, leads   -- of each mission from its request to a robot's start, and to its success
    use            -- robot seconds
    waiting        -- robot seconds by the edge that is waited for, and why
    docks, parked  -- the most robots that used docks, and that stood idle elsewhere, at once
    planning       -- s of this computer's time for each plan
    spent          -- the same for all: world, supervisor, planner
    trouble        -- why the run did not come to its end; empty: it did
    """

    robots: int
    seed: int
    seconds: float = 0.0
    requested: int = 0
    succeeded: int = 0
    open_at_end: int = 0
    failures: Dict[str, int] = field(default_factory=dict)
    waits: List[float] = field(default_factory=list)
    leads: List[float] = field(default_factory=list)
    use: Dict[Use, float] = field(default_factory=lambda: dict.fromkeys(Use, 0.0))
    waiting: Dict[Tuple[int, Cause], float] = field(default_factory=dict)
    docks: int = 0
    parked: int = 0
    travelled: float = 0.0
    planning: List[float] = field(default_factory=list)
    spent: Tuple[float, float, float] = (0.0, 0.0, 0.0)
    simulated: float = 0.0
    trouble: str = ''

    @property
    def per_hour(self) -> float:
        """Missions that succeeded, an hour."""
        return 3600.0 * self.succeeded / self.seconds if self.seconds else 0.0

    @property
    def speed(self) -> float:
        """Virtual s in one s of a core."""
        return self.simulated / sum(self.spent) if sum(self.spent) else 0.0

    @property
    def waiting_by_edge(self) -> Dict[int, float]:
        """Robot seconds of waiting, by edge id."""
        found: Dict[int, float] = {}
        for (edge, _), seconds in self.waiting.items():
            found[edge] = found.get(edge, 0.0) + seconds
        return found
