"""Why a mission or a robot does not go on. Programs and people get the same answer, made here.

While a robot serves a mission, the mission waits for the same thing as the robot.
"""
from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, isinf, nan
from typing import Optional, Sequence, Tuple

from fleet_core.interlocking.allocation import Knowledge
from fleet_core.interlocking.resources import Resource
from fleet_core.supervision.assignment import hindrances, why_nobody
from fleet_core.supervision.duties import Duty, Errand
from fleet_core.supervision.hindrances import WORDS, Hindrance
from fleet_core.supervision.missions import Mission, MissionState
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.supervisor import Supervisor
from fleet_core.supervision.time_to_go import time_to_go
from fleet_core.supervision.waits import FLEET_STOPPED, NO_WAIT, Wait, WaitCode


@dataclass(frozen=True)
class RobotReason:
    """Why one robot does not serve a mission that waits for a robot.

    mission -- request id of the mission that the robot serves; None: it serves none
    until   -- s until this mission probably ends; NaN: unknown
    text    -- in words
    """

    robot: str
    hindrance: Hindrance
    text: str
    mission: Optional[int] = None
    until: float = nan


@dataclass(frozen=True)
class MissionReason:
    """What an open mission waits for.

    robots -- if the mission waits for a robot: why each robot does not serve it
    """

    wait: Wait
    robots: Tuple[RobotReason, ...] = ()


def mission_reason(mission: Mission, supervisor: Supervisor, now: float) -> MissionReason:
    """Returns what an open mission waits for."""
    if mission.robot:
        robot = supervisor.robots[mission.robot]
        return MissionReason(robot_wait(robot, supervisor.errands()[robot.name], supervisor, now))
    if mission.state is MissionState.PAUSED:
        return MissionReason(_PAUSED)
    if mission.state is MissionState.PLANNED:
        return MissionReason(Wait(WaitCode.TIME, mission.reason,
                                  supervisor.times.until_earliest(mission)))
    if mission.state is MissionState.BLOCKED:
        return MissionReason(Wait(WaitCode.MISSIONS, mission.reason))
    acceptance = supervisor.acceptance
    room = supervisor.room()
    found = hindrances(mission, supervisor.own_hindrances, supervisor.robots, acceptance,
                       supervisor.networks.nominal, room)
    robots = tuple(
        _robot_reason(name, found[name] if name in found else acceptance.unfitness(
            mission.request, name), supervisor, now) for name in supervisor.robots)
    if supervisor.all_wait.code:
        return MissionReason(supervisor.all_wait, robots)
    reason = why_nobody(mission, found, supervisor.robots, now, room)[0]
    full = room.full(mission)
    if full is not None and Hindrance.FULL in found.values():
        return MissionReason(Wait(WaitCode.RESOURCE, reason, _until_free(
            room.robots_at(full), supervisor, now)), robots)
    ends = [one.until for one in robots if isfinite(one.until)]
    return MissionReason(Wait(WaitCode.ROBOT, reason, min(ends, default=nan)), robots)


def _robot_reason(name: str, hindrance: Hindrance, supervisor: Supervisor,
                  now: float) -> RobotReason:
    robot, serves = supervisor.robots[name], supervisor.book.of_robot(name)
    if hindrance is Hindrance.OUTAGE and robot.outage is not None:
        return RobotReason(name, hindrance, f'{WORDS[hindrance]}: '
                                            f'{robot.why or robot.outage.value}')
    if hindrance is not Hindrance.BUSY or serves is None:
        return RobotReason(name, hindrance, WORDS[hindrance])
    to_go = time_to_go(robot, supervisor.errand(robot), supervisor.plan_executor.plan,
                       supervisor.networks.edge_times, now)
    return RobotReason(name, hindrance, WORDS[hindrance].format(mission=serves.request.id),
                       serves.request.id, to_go.end / supervisor.rate)


_PAUSED = Wait(WaitCode.RESUME, 'its mission is paused')
_GOES_ON = Wait(WaitCode.START, 'its own standstill: it gets its next edges as soon as it stands')
_NEXT_EDGE = Wait(WaitCode.PLAN, 'the next edge of its plan')
_NEXT_PLAN = Wait(WaitCode.PLAN, 'a plan for its mission')


def robot_wait(robot: ManagedRobot, errand: Errand, supervisor: Supervisor, now: float) -> Wait:
    """Returns what a robot waits for. NOTHING: it drives, or has nothing to do."""
    mission = errand.mission
    if robot.knowledge is Knowledge.UNKNOWN:
        return Wait(WaitCode.UNKNOWN, 'it has never reported, so no robot may drive: switch it on, '
                                      f'or `fleet absent {robot.name}`')
    if robot.outage is not None:
        return Wait(WaitCode.OUTAGE, robot.why or robot.outage.value)
    if supervisor.is_stopped:
        return FLEET_STOPPED
    if supervisor.all_wait.code and errand.duty is not Duty.IDLE and robot.record.is_standing:
        return supervisor.all_wait
    if mission is not None and mission.state is MissionState.PAUSED:
        return _PAUSED
    return _errand_wait(robot, errand, supervisor, now)


def _errand_wait(robot: ManagedRobot, errand: Errand, supervisor: Supervisor, now: float) -> Wait:
    """Returns what a robot waits for on its errand although it may drive."""
    mission = errand.mission
    work = supervisor.desk.waits_for(robot.name, mission)
    if work.code:
        return work
    if robot.name in supervisor.charging.waiting:
        return Wait(WaitCode.CHARGING, supervisor.charging.waiting[robot.name])
    if errand.duty is Duty.IDLE:
        return NO_WAIT
    if errand.duty is Duty.QUEUE:
        return _turn(robot, supervisor, now)
    if mission is not None and mission.dwell_until is not None:
        return _stay(mission, mission.dwell_until - now)
    return _traffic(robot, mission, supervisor, now)


def _stay(mission: Mission, seconds: float) -> Wait:
    if not isinf(seconds):
        left = max(seconds, 0.0)
        return Wait(WaitCode.STAY, f'the end of its stay, {left:.0f} s', left)
    if mission.request.stops:
        return Wait(WaitCode.STEP, 'the end of its steps')
    return Wait(WaitCode.STAY, 'the release of its mission')


def _of_device(resource: Resource, supervisor: Supervisor, now: float) -> str:
    """Returns what the device of a resource shows, in words that follow the resource's name.

    Empty: the resource has no device.
    """
    if not resource.has_device:
        return ''
    mode, why = supervisor.devices.view(resource.name, now)
    return f' ({mode.name}{why and f": {why}"})'


def _turn(robot: ManagedRobot, supervisor: Supervisor, now: float) -> Wait:
    """Returns what a robot in the queue of a station waits for, and for how long."""
    standing = supervisor.stations.standing_of(robot.name)
    if standing is None:
        return NO_WAIT
    station = standing.station.name
    before = standing.ahead or supervisor.stations.inside(station)
    names, until = ', '.join(before), _until_free(before, supervisor, now)
    if standing.place is None:
        return Wait(WaitCode.RESOURCE, f'its turn at station {station}, which is full with its '
                                       f'queue: {names}', until)
    return Wait(WaitCode.RESOURCE, f'its turn at station {station}, after {names}', until)


def _until_free(before: Sequence[str], supervisor: Supervisor, now: float) -> float:
    """Returns the seconds until, at the latest, one of these robots has ended its work at a stop.
    """
    ends = [nan]
    for name in before:
        mission = supervisor.book.of_robot(name)
        if mission is None or mission.dwell_until is None:
            continue
        work = supervisor.desk.waits_for(name, mission)
        ends.append(work.until if work.code else mission.dwell_until - now)
    return max(min((end for end in ends if isfinite(end)), default=nan), 0.0)


def _traffic(robot: ManagedRobot, mission: Optional[Mission], supervisor: Supervisor,
             now: float) -> Wait:
    """Returns what keeps a robot with an errand from driving on."""
    executor, stands = supervisor.plan_executor, robot.record.is_standing
    if executor.trouble and stands:
        return Wait(WaitCode.PLAN, f'a plan: {executor.trouble}')
    if executor.plan is not None and robot.name in executor.plan.unserved:
        return Wait(WaitCode.PLAN, executor.plan.unserved[robot.name])
    if not stands:
        return NO_WAIT
    waits_for = executor.waits_for.get(robot.name, '')
    lacks = executor.lacks.get(robot.name)
    if lacks is not None:
        return Wait(WaitCode.RESOURCE, waits_for + _of_device(lacks, supervisor, now))
    if waits_for:
        return Wait(WaitCode.TRAFFIC, waits_for)
    if mission is None or robot.record.ahead:
        return NO_WAIT
    if robot.is_halted:
        return _GOES_ON
    is_planned = executor.plan is not None and robot.name in executor.plan.plans
    return _NEXT_EDGE if is_planned and not executor.is_planning else _NEXT_PLAN
