"""Messages of requests to the planner and of its answers.

Times in messages are ROS times. The planner counts seconds of the robots' time from the request's
stamp. With simulated robots, `rate` seconds of the robots' time pass in one ROS second.
"""
from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite
from typing import List, Mapping, Optional, Sequence, Tuple

import genpy

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.geometry.site_geometry import Alone
from fleet_core.interlocking.allocation import Allocation, Knowledge
from fleet_core.planning.plan_requests import PlanRequest, Times
from fleet_core.planning.precedence import Constraint
from fleet_core.planning.tasks import CannotPlan, Obstacle, PlannedDrive, PlanningOutcome, Task
from itrci_nav_msgs import msg

_LONGEST_NAME = 256
_NS = 1e9
_END_OF_TIME = 2 ** 32 * 10 ** 9 - 1  # ns, the latest time that a message can carry


class PlanningClock:
    """Converts ROS time to the planner's seconds and back.

    zero -- ROS time at which the planner's seconds are 0
    rate -- planner's seconds in one second of ROS time
    """

    def __init__(self, zero: genpy.Time, rate: float = 1.0) -> None:
        self._zero = zero.to_nsec()
        self.rate = rate

    def seconds(self, moment: genpy.Time) -> float:
        """Returns the planner's seconds at a ROS time."""
        return (moment.to_nsec() - self._zero) / _NS * self.rate

    def moment(self, seconds: float) -> genpy.Time:
        """Returns the ROS time of planner's seconds, limited to times that a message can carry."""
        nanoseconds = self._zero + round(seconds / self.rate * _NS)
        time = genpy.Time(0, min(max(nanoseconds, 0), _END_OF_TIME))
        time.canon()
        return time


# -- requests -------------------------------------------------------------------------------------


def request_of(message: msg.PlanRequest, types: Mapping[str, RobotType], edge_times: Times,
               time_limit: float, longest: float, rate: float = 1.0) -> PlanRequest:
    """Returns the request in a message. Raises CannotPlan for invalid values.

    types      -- robot types of the fleet, by name
    edge_times -- the table that the message uses, see messages.edge_times
    time_limit -- s for the search if the message gives none
    longest    -- s, the upper limit of its times for search and improvement
    """
    clock = PlanningClock(message.header.stamp, rate)
    laden = {one.name: _laden(one, types) for one in message.laden_types}
    types = {**types, **laden}
    for name, seconds in (('time_limit', message.time_limit),
                          ('improvement', message.improvement)):
        if not (isfinite(seconds) and seconds >= 0.0):
            raise CannotPlan(f'{name} is {seconds}, but must be a time in s, or 0.')
    return PlanRequest(
        tuple(_task(task, types, clock) for task in message.tasks),
        tuple(Obstacle(_name(robot.robot), _type(robot.robot, robot.robot_type, types),
                       tuple(robot.vertices), tuple(robot.edges),
                       tuple(_area(robot.robot, outline) for outline in robot.outlines))
              for robot in message.obstacles),
        frozenset(abs(edge) for edge in message.closed_edges),
        edge_times,
        tuple(Alone(frozenset(one.edges), frozenset(one.vertices)) for one in message.alone),
        frozenset(message.parking),
        min(message.time_limit or time_limit, longest), min(message.improvement, longest),
        message.seed, frozenset(message.reserved), tuple(laden.values()))


def request_message(request: PlanRequest, plan_id: int, stamp: genpy.Time,
                    graph_stamp: genpy.Time, rate: float = 1.0) -> msg.PlanRequest:
    """Returns a request as a message; `stamp` is the time at which the robots are where the tasks
    say.

    It has no learned times; messages.edge_times adds them.
    """
    clock = PlanningClock(stamp, rate)
    message = msg.PlanRequest(
        plan_id=plan_id, graph_stamp=graph_stamp, time_limit=request.time_limit,
        improvement=request.improvement, seed=request.seed, parking=sorted(request.parking),
        reserved=sorted(request.reserved),
        laden_types=[msg.LadenType(kind.name, kind.model, kind.radius, kind.speed,
                                   sorted(kind.closed)) for kind in request.laden],
        closed_edges=sorted(request.closed),
        alone=[msg.AlonePlaces(sorted(one.edges), sorted(one.vertices)) for one in request.alone],
        tasks=[_task_message(task, clock) for task in request.tasks],
        obstacles=[msg.FleetObstacle(robot.name, robot.type.name, list(robot.vertices),
                                     list(robot.edges), [_outline(area) for area in robot.areas])
                   for robot in request.obstacles])
    message.header.stamp = stamp
    return message


def _laden(message: msg.LadenType, types: Mapping[str, RobotType]) -> RobotType:
    if message.robot_type not in types:
        raise CannotPlan(f'The laden type {_name(message.name)} is one of {message.robot_type!r}, '
                         f'but the fleet file has {", ".join(types)}.')
    own = types[message.robot_type]
    if message.name in types or not (own.radius <= message.radius < inf and
                                     0.0 < message.speed <= own.speed):
        raise CannotPlan(f'The laden type {_name(message.name)} must have a name of its own, no '
                         f'smaller radius and no higher speed than {own.name}, and a speed above '
                         '0.')
    return replace(own, name=message.name, radius=message.radius, speed=message.speed,
                   without_load=own.name, own_speed=own.speed,
                   closed=frozenset(map(abs, message.closed_edges)))


def _task(message: msg.RobotTask, types: Mapping[str, RobotType], clock: PlanningClock) -> Task:
    name = _name(message.robot)
    mid_edge: Optional[Tuple[int, float]] = None
    if message.edge:
        mid_edge = message.edge, message.fraction
        if not 0.0 <= message.fraction <= 1.0:
            raise CannotPlan(f'Robot {name} stands at {message.fraction} of edge {message.edge}; '
                             'a fraction lies in 0..1.')
    kept: Optional[Tuple[PlannedDrive, ...]] = None
    if message.has_plan:
        kept = tuple(PlannedDrive(drive.edge_id, clock.seconds(drive.start),
                                  clock.seconds(drive.end)) for drive in message.kept)
    return Task(
        name, _type(name, message.robot_type, types), message.vertex or None,
        tuple(message.released), message.begun, mid_edge, message.ready * clock.rate,
        tuple(message.destinations), tuple(dwell * clock.rate for dwell in message.dwells),
        message.stays, kept, message.priority)


def _task_message(task: Task, clock: PlanningClock) -> msg.RobotTask:
    edge, fraction = task.mid_edge or (0, 0.0)
    return msg.RobotTask(
        task.name, task.type.name, task.vertex or 0, list(task.released), task.begun, edge,
        fraction, task.ready / clock.rate, list(task.destinations),
        [dwell / clock.rate for dwell in task.dwells], task.stays, task.kept is not None,
        _drives(task.kept or (), 0, clock), task.priority)


def _area(robot: str, outline: msg.Outline) -> Area:
    problem = ''
    if len(outline.x) != len(outline.y) or not outline.x:
        problem = f'{len(outline.x)} x and {len(outline.y)} y; give as many, and at least one'
    elif not all(map(isfinite, (*outline.x, *outline.y))):
        problem = 'numbers that are not finite; give x and y in m'
    elif not (isfinite(outline.radius) and outline.radius >= 0.0):
        problem = f'the radius {outline.radius}; give m, 0 or more'
    if problem:
        raise CannotPlan(f'An outline of robot {_name(robot)} has {problem}.')
    return Area(tuple(zip(outline.x, outline.y)), outline.radius)


def allocations_message(allocations: Mapping[str, Allocation],
                        now: genpy.Time) -> msg.FleetAllocations:
    """Returns the allocations of robots, by name; `now` is the stamp.

    Those of unknown places are left out.
    """
    message = msg.FleetAllocations(allocations=[msg.RobotAllocation(
        name, [hold.edge for hold in one.holds], [hold.cleared for hold in one.holds],
        one.vertex or 0, [_outline(area) for area in one.areas])
        for name, one in allocations.items() if one.knowledge is Knowledge.KNOWN])
    message.header.stamp = now
    return message


def _outline(area: Area) -> msg.Outline:
    return msg.Outline([x for x, _ in area.line], [y for _, y in area.line], area.radius)


def _name(name: str) -> str:
    if not (name.strip() and name.isprintable() and len(name) <= _LONGEST_NAME):
        raise CannotPlan(f'A robot is called {name[:_LONGEST_NAME]!r}; give it a name that can be '
                         'read.')
    return name


def _type(robot: str, name: str, types: Mapping[str, RobotType]) -> RobotType:
    if name not in types:
        raise CannotPlan(f'Robot {_name(robot)}: there is no robot type {name!r}; the fleet file '
                         f'has {", ".join(types)}.')
    return types[name]


# -- answers --------------------------------------------------------------------------------------


def answer_message(request: msg.PlanRequest, outcome: PlanningOutcome, planning_time: float,
                   rate: float = 1.0) -> msg.PlanAnswer:
    """Returns the answer to a request, with the plans of `outcome`."""
    answer = _answer(request, msg.PlanAnswer.PLANNED)
    write_outcome(answer, outcome, {task.robot: len(task.released) for task in request.tasks}, rate)
    answer.planning_time = planning_time
    return answer


def write_outcome(answer: msg.PlanAnswer, outcome: PlanningOutcome, released: Mapping[str, int],
                  rate: float = 1.0) -> None:
    """Puts the plans into an answer that has the request's stamp already.

    released -- how many drives of each robot are released already
    """
    clock = PlanningClock(answer.header.stamp, rate)
    names = dict.fromkeys((*released, *outcome.drives))  # in the order of the tasks
    answer.plans = [msg.RobotPlan(name, _drives(outcome.drives[name], released.get(name, 0), clock))
                    for name in names if name in outcome.drives]
    answer.precedence = [msg.Precedence(*constraint) for constraint in outcome.precedence]
    answer.unserved = [msg.UnservedRobot(*item) for item in outcome.unserved.items()]
    answer.cost = outcome.cost / rate
    answer.lower_bound = outcome.lower_bound / rate


def no_plan_message(request: msg.PlanRequest, result: int, reason: str) -> msg.PlanAnswer:
    """Returns the answer to a request for which nothing was planned.

    `result` is a code of PlanAnswer.
    """
    answer = _answer(request, result)
    answer.reason = reason
    return answer


def outcome_of(answer: msg.PlanAnswer, rate: float = 1.0) -> PlanningOutcome:
    """Returns the plans in an answer whose result is PLANNED."""
    clock = PlanningClock(answer.header.stamp, rate)
    return PlanningOutcome(
        {plan.robot: tuple(PlannedDrive(drive.edge_id, clock.seconds(drive.start),
                                        clock.seconds(drive.end)) for drive in plan.drives)
         for plan in answer.plans},
        tuple(Constraint(one.before, one.before_drive, one.fraction, one.robot, one.drive)
              for one in answer.precedence),
        {one.robot: one.reason for one in answer.unserved},
        answer.cost * rate, answer.lower_bound * rate)


def _answer(request: msg.PlanRequest, result: int) -> msg.PlanAnswer:
    answer = msg.PlanAnswer(plan_id=request.plan_id, result=result)
    answer.header.stamp = request.header.stamp
    return answer


def _drives(drives: Sequence[PlannedDrive], released: int,
            clock: PlanningClock) -> List[msg.PlannedDrive]:
    return [msg.PlannedDrive(drive.edge, clock.moment(drive.start), clock.moment(drive.end),
                             k < released) for k, drive in enumerate(drives)]
