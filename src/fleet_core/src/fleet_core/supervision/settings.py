"""The settings that the supervisor needs for each robot. They come from the fleet file."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RobotSettings:
    """The settings of one robot in the fleet file, in addition to its type.

    release_ahead -- m that are granted ahead of the robot, so that it need not brake
    slack         -- m by which the robot may be behind its reported place, along its path
    charge_below  -- state of charge (0..1) below which it goes to charge
    leave_above   -- state of charge at which it may leave the dock
    idle_below    -- state of charge below which it charges whenever it has nothing to do
    reserve       -- state of charge that must remain at the end of a mission
    endurance     -- m that it can drive on a full battery
    """

    release_ahead: float = 8.0
    slack: float = 0.0
    charge_below: float = 0.3
    leave_above: float = 0.8
    idle_below: float = 0.0
    reserve: float = 0.1
    endurance: float = 20000.0
