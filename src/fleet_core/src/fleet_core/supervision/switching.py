"""Switches the order of the plan in force if a robot holds up others.

`planning.order_switching` searches for the order. The driving times are those of the plan, which
includes learned times. The lateness of each robot follows from its present place, and from how long
robots usually stand.
"""
from __future__ import annotations

import math
import time
from typing import List, Optional, Tuple

from fleet_core.planning.edge_groups import RobotProgress, edge_groups
from fleet_core.planning.order_switching import LATE, RemainingDrives, switch_order
from fleet_core.planning.plans import Drive
from fleet_core.planning.tasks import PlannedDrive, PlanningOutcome
from fleet_core.supervision.assumptions import World
from fleet_core.supervision.duties import UNTIL_RELEASED, Duty, Errand
from fleet_core.supervision.plan_in_force import PlanInForce
from fleet_core.supervision.robot_plan import RobotPlan
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.standstills import Standstills

PERIOD = 1.0  # s between two searches
LIMIT = 0.02  # s of real time that one search may take


class OrderSwitching:
    """Looks for a better order, at most once in PERIOD s.

    clearance -- m that stays free between any two robots
    limit     -- s of real time that one search may take
    """

    def __init__(self, clearance: float, limit: float = LIMIT) -> None:
        self.switched = 0
        """Number of changes of the order."""
        self._clearance, self._limit = clearance, limit
        self._standstills = Standstills()
        self._looked = -math.inf

    def better(self, plan: PlanInForce, world: World, now: float) -> Optional[PlanInForce]:
        """Returns the plan in a better order; None: no such order, or too early to search."""
        if now - self._looked < PERIOD:
            return None
        self._looked = now
        deadline = time.monotonic() + self._limit
        courses = {name: _course(own, world.robots[name], world.errands[name],
                                 self._standstills.further(world.robots[name], now),
                                 now, now - plan.made_at)
                   for name, own in plan.plans.items()}
        if all(course.begins <= course.planned[0] + LATE
               for course in courses.values() if course.planned):
            return None
        found = edge_groups(world.network, self._clearance, {
            name: _progress(own, world.robots[name], world) for name, own in plan.plans.items()})
        switched = switch_order(courses, found, deadline=deadline)
        if switched is None:
            return None
        self.switched += 1
        drives = {name: _retimed(own, courses[name], switched.starts[name], now - plan.made_at)
                  for name, own in plan.plans.items()}
        return PlanInForce(PlanningOutcome(drives, switched.order(found), plan.unserved),
                           {name: own.base for name, own in plan.plans.items()}, plan.made_at,
                           plan.assumptions)


def _progress(own: RobotPlan, robot: ManagedRobot, world: World) -> RobotProgress:
    record = robot.record
    number, fraction = record.cleared
    released = record.end - own.base
    is_between = (record.is_standing and record.position is not None
                  and record.position.vertex is None)
    if is_between and released < len(own.drives):
        number, fraction = record.end, record.begun(
            own.drives[released].edge, record.position)
    plan = [Drive(world.network.drive(edge), start, end) for edge, start, end in own.drives]
    return RobotProgress(robot.type, plan, released, (max(number - own.base, 0), fraction),
                         is_between)


def _course(own: RobotPlan, robot: ManagedRobot, errand: Errand, delay: float, now: float,
            at: float) -> RemainingDrives:
    """Returns the remaining drives of a robot.

    delay -- s for which the robot will still stand at its place
    at    -- the present time on the plan's time scale
    """
    record = robot.record
    first = record.done - own.base
    left = own.drives[first:]
    seconds = [drive.end - drive.start for drive in left]
    pauses, done = _stays(own, first, robot, errand)
    begins = delay
    if record.ahead and left:
        if record.pose.edge == left[0].edge:
            begins -= record.pose.fraction * seconds[0]
    elif errand.mission is not None and errand.mission.dwell_until is not None:
        begins = min(max(errand.mission.dwell_until - now, 0.0), UNTIL_RELEASED)
    return RemainingDrives(first, begins, tuple(seconds), tuple(pauses),
                           tuple([drive.start - at for drive in left]), done)


def _stays(own: RobotPlan, first: int, robot: ManagedRobot,
           errand: Errand) -> Tuple[List[float], Optional[int]]:
    """Returns the stay before each remaining drive, and the number of the first drive after the
    errand.
    """
    pauses = [0.0] * max(len(own.drives) - first, 0)
    mission = errand.mission
    if mission is None or errand.duty is not Duty.MISSION:
        return pauses, len(own.drives) if errand.duty is Duty.CHARGE else None
    request, reached, done = mission.request, mission.reached, None
    if mission.dwell_until is not None:
        reached += 1
    for number, drive in enumerate(own.drives[first:], first + 1):
        vertex = robot.record.graph.end_vertex(drive.edge).id
        while reached < len(request.destinations) and request.destinations[reached] == vertex:
            stay = request.dwell(reached)
            if number - first < len(pauses):
                pauses[number - first] += stay if stay >= 0.0 else UNTIL_RELEASED
            reached, done = reached + 1, number
    return pauses, done


def _retimed(own: RobotPlan, course: RemainingDrives, starts: Tuple[float, ...],
             at: float) -> Tuple[PlannedDrive, ...]:
    """Returns the plan with the times of the new order."""
    left = [PlannedDrive(drive.edge, at + start, at + start + seconds) for drive, start, seconds
            in zip(own.drives[course.first:], starts, course.seconds)]
    return (*own.drives[:course.first], *left)
