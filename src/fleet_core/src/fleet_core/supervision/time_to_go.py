"""The time that a robot still needs. Everything that shows this time to people uses this estimate.

The times of a plan are made to compare paths. They omit the delay that robots of a type have on all
edges. This estimate uses the drives and waits of the plan, with the times that robots really
needed.
"""
from __future__ import annotations

from itertools import count
from math import inf, isnan, nan
from typing import Iterable, Iterator, NamedTuple, Optional, Sequence

from fleet_core.fleet import RobotType
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import PlannedDrive
from fleet_core.supervision.duties import Errand
from fleet_core.supervision.edge_times import EdgeTimes
from fleet_core.supervision.missions import Mission, MissionState
from fleet_core.supervision.plan_in_force import PlanInForce
from fleet_core.supervision.robots import ManagedRobot


class TimeToGo(NamedTuple):
    """Seconds of the robot's clock, NaN: unknown.

    destination -- until it is at its next destination
    end         -- until it is at the last destination of its mission, including the stays at
                   earlier destinations
    """

    destination: float = nan
    end: float = nan


UNKNOWN = TimeToGo()


class _TimedDrive(NamedTuple):
    """A drive that the robot still has to make, with the times that it is expected to need."""

    end: int
    """The vertex at its end."""
    wait: float
    """The planned wait before the drive, s."""
    seconds: float


def time_to_go(robot: ManagedRobot, errand: Errand, plan: Optional[PlanInForce],
               times: EdgeTimes, now: float) -> TimeToGo:
    """Returns the time that a robot needs for its errand; `now` is the supervisor's time.

    A plan for another errand is not used, because it may have a long stay where the errand has an
    endless one. If the robot has no mission, its destination is the end of its plan.
    """
    mission, own = errand.mission, None if plan is None else plan.plan_of(robot.name)
    if plan is None or own is None or not robot.works or not plan.is_for(robot.name, errand):
        return UNKNOWN
    drives = _timed(robot, own.behind(robot.record.done), times, now - plan.made_at)
    usual = times.usual(robot.type.name)
    if mission is not None:
        return _of_mission(mission, drives, usual, now) if (
            mission.state is MissionState.ACTIVE) else UNKNOWN
    needed = [usual * drive.wait + drive.seconds for drive in drives]
    return TimeToGo(sum(needed), sum(needed)) if needed else UNKNOWN


def _timed(robot: ManagedRobot, drives: Sequence[PlannedDrive], times: EdgeTimes,
           clock: float) -> Iterator[_TimedDrive]:
    """Yields the drives with their times. The robot may have begun the first drive already.

    clock -- the present time (s) on the time scale of the plan
    """
    record, kind = robot.record, robot.type.name
    begun = (record.pose.fraction if drives and record.pose.edge == drives[0].edge
             and not record.is_standing else 0.0)
    for drive in drives:
        yield _TimedDrive(
            record.graph.end_vertex(drive.edge).id,
            0.0 if begun else max(drive.start - clock, 0.0),
            (1.0 - begun) * times.expected(kind, drive.edge))
        clock, begun = drive.end, 0.0


def _of_mission(mission: Mission, drives: Iterable[_TimedDrive], usual: float,
                now: float) -> TimeToGo:
    """Returns the time that a mission needs for these drives.

    If a planned wait includes a stay, only the part of the wait beyond the stay is added.
    """
    stops = [(vertex, _stay(mission.request.dwell(mission.reached + number)))
             for number, vertex in enumerate(mission.left)]
    first, needed, stay = nan, 0.0, 0.0
    if mission.dwell_until is not None:
        stops, first, stay = stops[1:], 0.0, max(mission.dwell_until - now, 0.0)
    for drive in drives:
        needed += stay + max(drive.wait - stay, 0.0) * usual + drive.seconds
        stay = 0.0
        if stops and stops[0][0] == drive.end and isnan(first):
            first = needed
        while stops and stops[0][0] == drive.end:
            stay += stops.pop(0)[1]
        if not stops:
            return TimeToGo(first, needed if needed < inf else nan)
    return TimeToGo(first if first < inf else nan)


def _stay(dwell: float) -> float:
    """Returns the seconds of a stay at a destination; infinite: until a person ends it."""
    return dwell if dwell >= 0.0 else inf


def time_over(mission: Mission, kinds: Iterable[RobotType], network: RoadNetwork) -> float:
    """Returns the seconds from the next destination of a mission to its last one, without a plan.

    The fastest of `kinds` needs this time without traffic. The sum includes stays that have an end.
    Infinite: there is no path.
    """
    left = mission.left
    stays = sum(max(mission.request.dwell(index), 0.0)
                for index, _ in zip(count(mission.reached), left[:-1]))
    return stays + min((network.seconds_over(kind, left) for kind in kinds), default=inf)
