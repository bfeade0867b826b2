"""What one robot may occupy or still reach, given all evidence."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.geometry.areas import Area


class Knowledge(Enum):
    """What is known of where a robot is."""

    KNOWN = 'known'
    """It is within its allocation, switched on or off."""
    UNKNOWN = 'unknown'
    """It was never heard of, so it may be anywhere."""
    ABSENT = 'absent'
    """A person declared that it is not on the site."""


class Hold(NamedTuple):
    """An edge that a robot may be on.

    cleared -- the fraction of it, in driving direction, that lies behind the robot
    """

    edge: int
    """Signed id."""
    cleared: float = 0.0


@dataclass(frozen=True)
class Allocation:
    """All that one robot may occupy or still reach.

    holds  -- edges that it was granted and has not certainly left, in driving order
    vertex -- id of the one on which it stands
    areas  -- where it stands between vertices, and what evidence adds to all this
    """

    kind: RobotType
    knowledge: Knowledge
    holds: Tuple[Hold, ...] = ()
    vertex: Optional[int] = None
    areas: Tuple[Area, ...] = ()
