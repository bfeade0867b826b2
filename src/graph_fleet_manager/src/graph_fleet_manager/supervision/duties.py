"""What each robot is to do next: what the planner is asked for, and how far a robot may go."""
from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.planning.tasks import PlannedDrive
from graph_fleet_manager.supervision.missions import Mission, MissionState
from graph_fleet_manager.supervision.robot_plan import RobotPlan
from graph_fleet_manager.supervision.robots import ManagedRobot
from trajectory_graph import Graph

UNTIL_RELEASED = 3600.0  # s that a dwell without an end is planned for
WINDOW = 8               # destinations of a mission for which a plan is made at once


class Duty(Enum):
    """What a robot is about."""

    IDLE = 'idle'        # makes room where another robot needs it
    MISSION = 'mission'
    CHARGE = 'charge'
    STAND = 'stand'      # paused: it stays where it is


@dataclass(frozen=True)
class Errand:
    """What one robot is to do.

    mission -- that it serves, paused or not
    dock    -- at which it is to charge
    """

    duty: Duty = Duty.IDLE
    mission: Optional[Mission] = None
    dock: Optional[int] = None

    @property
    def key(self) -> Tuple[Duty, int, int, int]:
        """The same as long as a plan for it serves.

        A stay without an end is planned to last long, so its end makes another plan worth it.
        """
        if self.mission is None:
            return self.duty, self.dock or 0, 0, 0
        stays = self.mission.dwell_until == math.inf
        return (self.duty, self.mission.serial, self.mission.reached if stays else -1,
                self.mission.changes)


def errand_of(mission: Optional[Mission], dock: Optional[int]) -> Errand:
    """A mission comes before charging, unless it is paused."""
    if mission is not None:
        paused = mission.state is MissionState.PAUSED
        return Errand(Duty.STAND if paused else Duty.MISSION, mission)
    return Errand(Duty.CHARGE, None, dock) if dock is not None else Errand()


class Visits(NamedTuple):
    """The next destinations of a mission, and s to stay at each (empty: nowhere).

    reach -- how many of the mission's destinations are known with these; None: all
    """

    destinations: Tuple[int, ...]
    dwells: Tuple[float, ...]
    reach: Optional[int]


def to_visit(robot: ManagedRobot, mission: Mission, now: float) -> Visits:
    """What is to be visited behind what the robot was granted already."""
    graph = robot.record.graph
    ahead = [graph.end_vertex(edge).id for edge in robot.record.ahead]
    first = mission.reached + mission.visits(ahead)
    some = slice(first, first + WINDOW)
    destinations = mission.request.destinations[some]
    reach = some.stop if some.stop < len(mission.request.destinations) else None
    if not mission.request.dwells:
        return Visits(destinations, (), reach)
    dwells = [dwell if dwell >= 0.0 else UNTIL_RELEASED for dwell in mission.request.dwells[some]]
    if dwells and first == mission.reached and mission.dwell_until is not None:
        dwells[0] = (UNTIL_RELEASED if math.isinf(mission.dwell_until)
                     else max(mission.dwell_until - now, 0.0))
    return Visits(destinations, tuple(dwells), reach)


def goes_until(robot: ManagedRobot, errand: Errand, own: RobotPlan, asked: bool,
               reach: Optional[int] = None) -> int:
    """Number of the record's edge before which a robot must stop in any case.

    reach -- how many destinations of its mission the plan knows of; None: all

    On a mission: at a destination where it stays, and at the last one that the plan knows of. Idle,
    or with a plan that does not lead to its destination: where it is, unless another robot asks it
    to make room.
    """
    record = robot.record
    end = own.base + len(own.drives)
    if errand.duty is Duty.STAND:
        return record.end
    if errand.duty is Duty.CHARGE:
        return end
    if errand.mission is not None:
        stop = _next_stop(record.graph, own.behind(record.done), errand.mission, reach)
        if stop is not None:
            return record.done + stop
    return end if asked else record.end


def _next_stop(graph: Graph, drives: Sequence[PlannedDrive], mission: Mission,
               reach: Optional[int]) -> Optional[int]:
    """How many drives lead to the next destination at which a robot stops; None: not all do."""
    request, index = mission.request, mission.reached
    last = len(request.destinations) if reach is None else reach
    if mission.dwell_until is not None:
        return 0
    for number, drive in enumerate(drives, 1):
        vertex = graph.end_vertex(drive.edge).id
        while index < len(request.destinations) and request.destinations[index] == vertex:
            index += 1
            if request.dwell(index - 1) or index == last:
                return number
    return None
