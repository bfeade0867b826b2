"""The time that a robot still needs, as people are shown it. This is its only estimate.

A plan is made to choose well, so its times leave out what all robots of a type lose everywhere.
This estimate takes the drives and waits of the plan, with the times that robots have really needed.
"""
from __future__ import annotations

from itertools import count
from math import inf, nan
from typing import Iterable, NamedTuple, Optional

from fleet_core.fleet import RobotType
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.edge_times import EdgeTimes
from fleet_core.supervision.missions import Mission, MissionState
from fleet_core.supervision.plan_in_force import PlanInForce
from fleet_core.supervision.robots import ManagedRobot


class TimeToGo(NamedTuple):
    """Seconds of the robot's clock, NaN: unknown.

    destination -- until it is at its next destination
    end         -- until it is at the last destination of its mission, with its stays before that
    """

    destination: float = nan
    end: float = nan


UNKNOWN = TimeToGo()


def time_to_go(robot: ManagedRobot, mission: Optional[Mission], plan: Optional[PlanInForce],
               times: EdgeTimes, now: float) -> TimeToGo:
    """The time that a robot needs by the plan in force; `now` is the supervisor's time.

    Without a mission the robot's destination is the end of its plan.
    """
    own = None if plan is None else plan.plan_of(robot.name)
    if plan is None or own is None or not robot.works or (
            mission is not None and mission.state is not MissionState.ACTIVE):
        return UNKNOWN
    record, left = robot.record, () if mission is None else mission.left
    index, first, stay = 0 if mission is None else mission.reached, nan, 0.0
    if mission is not None and mission.dwell_until is not None:
        left, index, first = left[1:], index + 1, 0.0
        stay = max(mission.dwell_until - now, 0.0)
    drives = own.behind(record.done)
    begun = (record.pose.fraction if drives and record.pose.edge == drives[0].edge
             and not record.is_standing else 0.0)
    clock, needed = now - plan.made_at, 0.0
    for number, drive in enumerate(drives):
        wait = 0.0 if begun else max(drive.start - clock, 0.0)
        traffic = max(wait - stay, 0.0) * times.usual(robot.type.name)
        needed += stay + traffic + (1.0 - begun) * times.expected(robot.type.name, drive.edge)
        clock, begun, stay = drive.end, 0.0, 0.0
        vertex = record.graph.end_vertex(drive.edge).id
        while mission is not None and left and left[0] == vertex:
            first = needed if first != first else first
            dwell = mission.request.dwell(index)
            left, index = left[1:], index + 1
            stay += dwell if dwell >= 0.0 else inf
        if mission is not None and not left:
            return TimeToGo(first, needed if needed < inf else nan)
        if number + 1 == len(drives) and mission is None:
            return TimeToGo(needed, needed)
    return TimeToGo(first if first < inf else nan)


def time_over(mission: Mission, kinds: Iterable[RobotType], network: RoadNetwork) -> float:
    """s from the next destination of a mission to its last one, if the plan does not tell.

    The fastest type, without traffic, with stays that have a length. Infinite: there is no path.
    """
    left = mission.left
    stays = sum(max(mission.request.dwell(index), 0.0)
                for index, _ in zip(count(mission.reached), left[:-1]))

    def seconds(kind: RobotType) -> float:
        return sum(float(network.paths_to(kind, (network.index[other],))[0][network.index[one]])
                   for one, other in zip(left, left[1:]))
    return stays + min(map(seconds, kinds), default=inf)
