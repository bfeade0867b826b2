"""What a fleet file says of each robot that the supervisor needs."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RobotSettings:
    """What the fleet file says of one robot beside its type.

    release_ahead -- m that it is let go ahead of where it is, so that it need not brake
    slack         -- m that it may be short of where it reports to be, along its path
    stopping      -- m that it may need to stop once it has acknowledged a shorter route
    charge_below  -- state of charge (0..1) below which it goes to charge
    leave_above   -- state of charge from which on it may leave again
    reserve       -- state of charge that it must have left when a mission ends
    endurance     -- m that it drives on a full battery
    """

    release_ahead: float = 8.0
    slack: float = 0.0
    stopping: float = 1.0
    charge_below: float = 0.3
    leave_above: float = 0.8
    reserve: float = 0.1
    endurance: float = 20000.0
