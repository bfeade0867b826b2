"""The errand of each robot: the input of the planner, and the limit of the grants."""
from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Iterable, NamedTuple, Optional, Sequence, Tuple

from fleet_core.planning.tasks import PlannedDrive
from fleet_core.supervision.missions import Mission, MissionState
from fleet_core.supervision.robot_plan import RobotPlan
from fleet_core.supervision.robots import ManagedRobot
from trajectory_graph import Graph

UNTIL_RELEASED = 3600.0  # s that are planned for a dwell without an end
WINDOW = 8               # number of a mission's destinations that are planned at once


class Duty(Enum):
    """The kind of an errand."""

    IDLE = 'idle'        # it makes room if another robot needs its place
    MISSION = 'mission'
    CHARGE = 'charge'
    STAND = 'stand'      # its mission is paused, or waits for an answer: it stays where it is


@dataclass(frozen=True)
class Errand:
    """What one robot has to do next.

    mission -- the mission that it serves, paused or not
    dock    -- the dock at which it is to charge
    """

    duty: Duty = Duty.IDLE
    mission: Optional[Mission] = None
    dock: Optional[int] = None

    @property
    def key(self) -> Tuple[Duty, int, int, int]:
        """A key that stays the same as long as a plan for the errand is useful.

        A stay without an end is planned to last long. So the key changes when such a stay ends.
        """
        if self.mission is None:
            return self.duty, self.dock or 0, 0, 0
        stays = self.mission.dwell_until == math.inf
        return (self.duty, self.mission.serial, self.mission.reached if stays else -1,
                self.mission.changes)


def errand_of(mission: Optional[Mission], dock: Optional[int]) -> Errand:
    """The errand of a robot. A mission comes before charging, unless it is paused."""
    if mission is not None:
        stands = mission.state is MissionState.PAUSED or mission.is_held
        return Errand(Duty.STAND if stands else Duty.MISSION, mission)
    return Errand(Duty.CHARGE, None, dock) if dock is not None else Errand()


class Visits(NamedTuple):
    """The next destinations of a mission, and the seconds to stay at each (empty: no stays).

    reach -- number of the mission's destinations up to the last one here; None: all
    """

    destinations: Tuple[int, ...]
    dwells: Tuple[float, ...]
    reach: Optional[int]


def to_visit(released: Iterable[int], graph: Graph, mission: Mission, now: float) -> Visits:
    """The next destinations behind those that the released edges ahead visit already."""
    first = mission.reached + mission.visits([graph.end_vertex(edge).id for edge in released])
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
    """Number of the edge in the record before which a robot must stop in any case.

    reach -- number of its mission's destinations that the plan includes; None: all

    - On a mission, the robot stops at a destination where it stays, and at the last one that the
      plan includes.
    - An idle robot, and one whose plan does not lead to its destination, stops where it is, unless
      another robot asks it to make room.
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
    """Number of drives to the next destination at which the robot stops; None: not reached."""
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
