"""The allocation of one robot: all places that it may occupy or still reach, given all evidence."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import Dict, NamedTuple, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area


class Knowledge(Enum):
    """What the fleet manager knows of a robot's place."""

    KNOWN = 'known'
    """The robot is within its allocation, switched on or off."""
    UNKNOWN = 'unknown'
    """The robot has never reported, or the journal is an older one: it may be anywhere."""
    ABSENT = 'absent'
    """A person declared that the robot is not on the site."""


class Hold(NamedTuple):
    """An edge that a robot may be on.

    cleared -- the fraction of the edge, in driving direction, that lies behind the robot
    """

    edge: int
    """Signed id."""
    cleared: float = 0.0


@dataclass(frozen=True)
class Allocation:
    """All places that one robot may occupy or still reach.

    holds  -- edges that the robot was granted and has not certainly left, in driving order
    vertex -- id of the vertex on which the robot stands; None: it stands on none
    areas  -- the point where the robot stands between vertices, and areas that evidence adds
    """

    kind: RobotType
    knowledge: Knowledge
    holds: Tuple[Hold, ...] = ()
    vertex: Optional[int] = None
    areas: Tuple[Area, ...] = ()

    def is_within(self, other: Allocation) -> bool:
        """Returns whether `other`, of the same robot, has every place of this allocation.

        If so, this allocation excludes no robot that `other` does not exclude. Both must have the
        same knowledge, and the robot's reach must not be larger than in `other`.
        """
        if self.knowledge is not other.knowledge or self.kind.reach > other.kind.reach or (
                self.vertex not in (None, other.vertex)
                or not set(self.areas) <= set(other.areas)):
            return False
        cleared: Dict[int, float] = {}
        for hold in other.holds:
            cleared[hold.edge] = min(hold.cleared, cleared.get(hold.edge, 1.0))
        return all(hold.cleared >= cleared.get(hold.edge, inf) for hold in self.holds)
