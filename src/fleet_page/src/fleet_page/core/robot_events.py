"""Events of robots: each change of a robot's state, trouble, work or mission."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from fleet_page.core.fleet import ShownRobot, alarm_of


@dataclass(frozen=True)
class RobotEvent:
    """A robot after a change.

    time    -- s since 1970
    works   -- whether it carries out a step at a stop
    alarm   -- why it needs a person, as one of ALARMS; empty: it needs none
    mission -- request id; None: it has no mission
    """

    time: float
    robot: str
    state: str
    outage: str
    works: bool
    alarm: str
    waits_for: str
    mission: Optional[int]


def event_between(before: ShownRobot, after: ShownRobot, now: float) -> Optional[RobotEvent]:
    """Returns the event between two reports of a robot; None: no such change."""
    if _what(before) == _what(after):
        return None
    return RobotEvent(now, after.name, after.state, after.outage, after.is_working,
                      alarm_of(after), after.waits_for, after.mission)


def _what(robot: ShownRobot) -> object:
    return robot.state, robot.outage, robot.is_working, alarm_of(robot), robot.mission
