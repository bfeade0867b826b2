"""Robots as clients see them: their states, and why a robot serves no jobs."""
from __future__ import annotations

from typing import List, Mapping, NamedTuple

from omron_jobs.core.job_words import APPLICATION_FAULT, RobotStatus


class RobotNews(NamedTuple):
    """The state of a robot, as it is shown."""

    status: RobotStatus
    substatus: str


class RobotFault(NamedTuple):
    """A reason why a robot serves no jobs. While the robot has the fault, it drives to no jobs.

    No fault is called critical, because the fleet manager does not report which faults a person
    must clear.
    is_application -- whether the substatus of the robot says that an application has this fault
    """

    robot: str
    name: str
    is_application: bool

    @property
    def type(self) -> str:
        """The type, in OMRON's words."""
        return 'Fault_Driving_Application' if self.is_application else 'Fault_Driving'

    @property
    def text(self) -> str:
        """A sentence for people."""
        return f'{self.robot} serves no jobs ({self.name})'


def faults_of(robots: Mapping[str, RobotNews]) -> List[RobotFault]:
    """Returns the faults of these robots, in the order of their names."""
    found = []
    for robot, news in sorted(robots.items()):
        if news.status is RobotStatus.UNAVAILABLE:
            is_application = news.substatus.startswith(APPLICATION_FAULT)
            name = news.substatus[len(APPLICATION_FAULT) if is_application else 0:]
            found.append(RobotFault(robot, name, is_application))
    return found
