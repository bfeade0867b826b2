"""The results of one simulation run."""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Dict, List, Tuple

from fleet_simulation.hold_ups import ResourceUse


class Use(Enum):
    """What a robot does at one moment. The report shows how long the robots spent on each
    activity.
    """

    LOADED = 'driving with a mission'
    EMPTY = 'driving without a mission'
    STAY = 'at a destination'
    HELD = 'docking, stalled, or blocked by a person'
    WAITING = 'waiting'
    CHARGING = 'charging'
    IDLE = 'idle'
    OUT = 'out of order'


class WaitingCause(Enum):
    """The reason why a robot waits."""

    ROBOT = 'another robot'
    PLANNER = 'the planner'
    NO_PLAN = 'no plan serves it'
    RESOURCE = 'a station or device'
    CLOSED = 'a closed edge'
    OWN = 'its own start'


@dataclass
class TimetableUse:
    """The results of the missions of one timetable in one run. Times are virtual s.

    requested, succeeded -- missions
    leads     -- for each mission: time from its request until it succeeds
    deadlines, missed -- as in `Figures`
    """

    requested: int = 0
    succeeded: int = 0
    leads: List[float] = field(default_factory=list)
    deadlines: int = 0
    missed: int = 0

    def add(self, other: TimetableUse) -> None:
        """Adds the missions of another run."""
        self.requested += other.requested
        self.succeeded += other.succeeded
        self.leads = [*self.leads, *other.leads]
        self.deadlines += other.deadlines
        self.missed += other.missed


@dataclass
class Figures:
    """The figures of one run, one field for each figure of the report.

    Times are virtual s, except `planning` and `spent`.

    seconds        -- measured time, after the warm-up
    requested, succeeded -- missions that were requested, and that succeeded, in the measured time
    open_at_end    -- missions that are still open when the run ends
    failures       -- failed missions by reason
    waits          -- for each mission: time from its request until a robot starts it
    leads          -- for each mission: time from its request until it succeeds
    use            -- robot seconds by activity
    waiting        -- robot seconds of waiting, by the edge for which a robot waits, and by cause
    resources      -- use of each station, device and charger, by its name
    timetables     -- results of each timetable of the work file, by its name
    deadlines      -- missions with a deadline that ended, or whose deadline passed
    missed         -- missions of `deadlines` that were not done in time
    docks          -- largest number of robots that charged at the same time
    parked         -- largest number of robots that were idle at the same time without charging
    travelled      -- distance (m) that all robots drove, warm-up included
    planning       -- processor time (s) that each plan took
    spent          -- processor time (s) of the whole run: world, supervisor, planner
    simulated      -- length of the whole run, warm-up included
    trouble        -- why the run broke off; empty if it was completed
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
    waiting: Dict[Tuple[int, WaitingCause], float] = field(default_factory=dict)
    resources: Dict[str, ResourceUse] = field(default_factory=dict)
    timetables: Dict[str, TimetableUse] = field(default_factory=dict)
    deadlines: int = 0
    missed: int = 0
    docks: int = 0
    parked: int = 0
    travelled: float = 0.0
    planning: List[float] = field(default_factory=list)
    spent: Tuple[float, float, float] = (0.0, 0.0, 0.0)
    simulated: float = 0.0
    trouble: str = ''

    @property
    def per_hour(self) -> float:
        """Succeeded missions per hour."""
        return 3600.0 * self.succeeded / self.seconds if self.seconds else 0.0

    @property
    def speed(self) -> float:
        """Virtual s per s of processor time of one core."""
        return self.simulated / sum(self.spent) if sum(self.spent) else 0.0

    @property
    def waiting_by_edge(self) -> Dict[int, float]:
        """Robot seconds of waiting, by edge id."""
        found: Dict[int, float] = {}
        for (edge, _), seconds in self.waiting.items():
            found[edge] = found.get(edge, 0.0) + seconds
        return found
