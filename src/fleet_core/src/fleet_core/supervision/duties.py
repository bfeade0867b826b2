"""The errand of each robot. It determines the planner's task and how far grants may lead."""
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

UNTIL_RELEASED = 3600.0  # s: the planned duration of a dwell without an end
WINDOW = 8               # maximum number of a mission's destinations in one plan


class Duty(Enum):
    """The kind of an errand."""

    IDLE = 'idle'        # it makes room if another robot needs its place
    MISSION = 'mission'
    CHARGE = 'charge'
    QUEUE = 'queue'      # it waits for its turn at a station: at a queue place, or where it is
    STAND = 'stand'      # its mission is paused, or waits for an answer: it stays where it is


ErrandKey = Tuple[Duty, int, int, int, int]


class StationLimit(NamedTuple):
    """How far the stations let a robot go.

    reach  -- number of its mission's destinations before the next station for which it has no turn;
              None: it has no such station ahead
    waits  -- its next destination is at that station
    place  -- the queue place for the robot; None: it waits where it is
    is_there -- the edges that it was granted end at that queue place
    leaves -- it has no work at its station or charger, and another robot waits for its place
    """

    reach: Optional[int] = None
    waits: bool = False
    place: Optional[int] = None
    is_there: bool = False
    leaves: bool = False


NO_LIMIT = StationLimit()


@dataclass(frozen=True)
class Errand:
    """What one robot has to do next.

    mission -- the mission that it serves, paused or not
    place   -- the dock at which it is to charge, or the queue place at which it waits
    limit   -- how far it may go, and whether it must leave
    """

    duty: Duty = Duty.IDLE
    mission: Optional[Mission] = None
    place: Optional[int] = None
    limit: StationLimit = NO_LIMIT

    @property
    def key(self) -> ErrandKey:
        """A key that stays the same as long as a plan for the errand is useful.

        A stay without an end is planned to last long. So the key changes when such a stay ends. The
        key also changes when a robot had to leave its queue place: a new plan must lead it back.
        """
        if self.mission is None or self.duty is Duty.QUEUE:
            return self.duty, self.place or 0, int(self.limit.is_there), 0, 0
        stays = self.mission.dwell_until == math.inf
        return (self.duty, self.mission.serial, self.mission.reached if stays else -1,
                self.mission.changes, -1 if self.limit.reach is None else self.limit.reach)

    @property
    def stays(self) -> bool:
        """Whether the robot is to stay at the place of its errand."""
        return self.place is not None

    @property
    def is_to_drive(self) -> bool:
        """Whether the robot is to drive to another place. If so, other robots make room for it."""
        if self.duty is Duty.QUEUE:
            return self.limit.leaves or self.place is not None and not self.limit.is_there
        return self.limit.leaves or self.duty in (Duty.MISSION, Duty.CHARGE)


def errand_of(mission: Optional[Mission], dock: Optional[int],
              limit: StationLimit = NO_LIMIT) -> Errand:
    """Returns the errand of a robot. A mission comes before charging, unless it is paused."""
    if mission is not None and follows(mission):
        return Errand(Duty.QUEUE if limit.waits else Duty.MISSION, mission, limit.place, limit)
    if mission is not None:
        return Errand(Duty.STAND, mission)
    return Errand(Duty.CHARGE, None, dock) if dock is not None else Errand(limit=limit)


def follows(mission: Mission) -> bool:
    """Returns whether the robot of a mission goes on to its next destination."""
    return mission.state is not MissionState.PAUSED and not mission.is_held


class Visits(NamedTuple):
    """The next destinations of a mission, and the seconds to stay at each (empty: no stays).

    reach -- number of the mission's destinations up to the last of `destinations`; None: all
    """

    destinations: Tuple[int, ...]
    dwells: Tuple[float, ...]
    reach: Optional[int]


def to_visit(released: Iterable[int], graph: Graph, mission: Mission, now: float,
             end: Optional[int] = None) -> Visits:
    """Returns the next destinations, without those that the released edges ahead visit already.

    end -- number of destinations that the robot may visit now; None: all
    """
    first = mission.reached + mission.visits([graph.end_vertex(edge).id for edge in released])
    last = len(mission.request.destinations) if end is None else end
    some = slice(first, min(first + WINDOW, last))
    destinations = mission.request.destinations[some]
    reach = some.stop if some.stop < last else None
    if not mission.request.dwells:
        return Visits(destinations, (), reach)
    dwells = [dwell if dwell >= 0.0 else UNTIL_RELEASED for dwell in mission.request.dwells[some]]
    if dwells and first == mission.reached and mission.dwell_until is not None:
        dwells[0] = (UNTIL_RELEASED if math.isinf(mission.dwell_until)
                     else max(mission.dwell_until - now, 0.0))
    return Visits(destinations, tuple(dwells), reach)


def goes_until(robot: ManagedRobot, errand: Errand, own: RobotPlan, asked: bool,
               reach: Optional[int] = None) -> int:
    """Returns the number of the edge in the record before which a robot must stop in any case.

    asked -- another robot, or a station, needs the robot's place
    reach -- number of its mission's destinations that the plan includes; None: all

    - On a mission, the robot stops at a destination where it stays, and at the last one that the
      plan includes.
    - In a queue, it stops at its queue place.
    - An idle robot, and a robot whose plan does not lead to its destination, stops where it is,
      unless it is asked to make room.
    """
    record = robot.record
    end = own.base + len(own.drives)
    if errand.duty is Duty.STAND:
        return record.end
    if errand.duty is Duty.CHARGE:
        return end
    if errand.duty is Duty.QUEUE:
        return end if asked else _end_at(errand, own, robot)
    if errand.mission is not None:
        ends = [number for number in (reach, errand.limit.reach) if number is not None]
        stop = _next_stop(record.graph, own.behind(record.done), errand.mission,
                          min(ends, default=None))
        if stop is not None:
            return record.done + stop
    return end if asked else record.end


def _end_at(errand: Errand, own: RobotPlan, robot: ManagedRobot) -> int:
    """Returns the number after the edge that leads to the queue place.

    If the robot is there, or its plan does not lead there: the end of its record.
    """
    record = robot.record
    if errand.limit.is_there:
        return record.end
    ends = (number for number, drive in enumerate(own.drives, own.base + 1)
            if number > record.end and record.graph.end_vertex(drive.edge).id == errand.place)
    return next(ends, record.end)


def _next_stop(graph: Graph, drives: Sequence[PlannedDrive], mission: Mission,
               reach: Optional[int]) -> Optional[int]:
    """Returns the number of drives to the next destination at which the robot stops.

    None: the drives do not lead to such a destination.
    """
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
