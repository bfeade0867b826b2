"""Messages of requests to the planner and of its answers.

Times in messages are seconds of ROS time after the stamp of the request. The planner counts the
same times in seconds of the robots' time: with simulated robots, `rate` seconds of the robots' time
pass in one second of ROS time.
"""
from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite
from typing import Dict, Mapping, Optional, Sequence, Tuple

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


class WrongAnswer(Exception):
    """An answer of the planner that is no plan. The text is a clause that says why."""


# -- requests -------------------------------------------------------------------------------------


def request_of(message: msg.PlanRequest, types: Mapping[str, RobotType], edge_times: Times,
               time_limit: float, longest: float, rate: float = 1.0) -> PlanRequest:
    """Returns the request in a message. Raises CannotPlan for invalid values.

    types      -- robot types of the fleet, by name
    edge_times -- the table that the message uses, see messages.edge_times
    time_limit -- s for the search if the message gives none
    longest    -- s, the upper limit of the message's times for search and improvement
    """
    laden = {one.name: _laden(one, types) for one in message.laden_types}
    types = {**types, **laden}
    for name, seconds in (('time_limit', message.time_limit),
                          ('improvement', message.improvement)):
        if not (isfinite(seconds) and seconds >= 0.0):
            raise CannotPlan(f'{name} is {seconds}, but must be a time in s, or 0.')
    return PlanRequest(
        tuple(_task(task, types, rate) for task in message.tasks),
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
    """Returns a request as a message, without the learned times: messages.edge_times adds them.

    stamp -- time at which the robots are at the places that the tasks name
    """
    message = msg.PlanRequest(
        plan_id=plan_id, graph_stamp=graph_stamp, time_limit=request.time_limit,
        improvement=request.improvement, seed=request.seed, parking=sorted(request.parking),
        reserved=sorted(request.reserved),
        laden_types=[msg.LadenType(kind.name, kind.model, kind.radius, kind.speed,
                                   sorted(kind.closed)) for kind in request.laden],
        closed_edges=sorted(request.closed),
        alone=[msg.AlonePlaces(sorted(one.edges), sorted(one.vertices)) for one in request.alone],
        tasks=[_task_message(task, rate) for task in request.tasks],
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


def _task(message: msg.RobotTask, types: Mapping[str, RobotType], rate: float) -> Task:
    name = _name(message.robot)
    mid_edge: Optional[Tuple[int, float]] = None
    if message.edge:
        mid_edge = message.edge, message.fraction
        if not 0.0 <= message.fraction <= 1.0:
            raise CannotPlan(f'Robot {name} stands at {message.fraction} of edge {message.edge}; '
                             'a fraction lies in 0..1.')
    kept: Optional[Tuple[PlannedDrive, ...]] = None
    if message.has_plan:
        fault = _fault_of(message.kept)
        if fault:
            raise CannotPlan(f'The kept plan of robot {name} has {fault}.')
        kept = _drives_of(message.kept, rate)
    return Task(
        name, _type(name, message.robot_type, types), message.vertex or None,
        tuple(message.released), message.begun, mid_edge, message.ready * rate,
        tuple(message.destinations), tuple(dwell * rate for dwell in message.dwells),
        message.stays, kept, message.priority)


def _task_message(task: Task, rate: float) -> msg.RobotTask:
    edge, fraction = task.mid_edge or (0, 0.0)
    return msg.RobotTask(
        task.name, task.type.name, task.vertex or 0, list(task.released), task.begun, edge,
        fraction, task.ready / rate, list(task.destinations),
        [dwell / rate for dwell in task.dwells], task.stays, task.kept is not None,
        _drives_message(task.kept or (), rate), task.priority)


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
    """Returns the allocations of robots, by name, without robots in unknown places; `now` is the
    stamp.
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
    """Puts the plans into an answer.

    released -- how many drives of each robot are already released
    """
    names = dict.fromkeys((*released, *outcome.drives))  # the robots of the tasks come first
    answer.plans = [msg.RobotPlan(name, _drives_message(outcome.drives[name], rate),
                                  min(released.get(name, 0), len(outcome.drives[name])))
                    for name in names if name in outcome.drives]
    answer.precedence = _precedence_message(outcome.precedence)
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
    """Returns the plans in an answer whose result is PLANNED. Raises WrongAnswer."""
    for plan in answer.plans:
        fault = _fault_of(plan.drives)
        if fault:
            raise WrongAnswer(f'the plan of {plan.robot[:_LONGEST_NAME]!r} has {fault}')
    return PlanningOutcome(
        {plan.robot: _drives_of(plan.drives, rate) for plan in answer.plans},
        _constraints_of(answer.precedence),
        {one.robot: one.reason for one in answer.unserved},
        answer.cost * rate, answer.lower_bound * rate)


def _answer(request: msg.PlanRequest, result: int) -> msg.PlanAnswer:
    answer = msg.PlanAnswer(plan_id=request.plan_id, result=result)
    answer.header.stamp = request.header.stamp
    return answer


# -- drives and their order -----------------------------------------------------------------------


def _drives_message(drives: Sequence[PlannedDrive], rate: float) -> msg.PlannedDrives:
    return msg.PlannedDrives([drive.edge for drive in drives],
                             [drive.start / rate for drive in drives],
                             [drive.end / rate for drive in drives])


def _fault_of(drives: msg.PlannedDrives) -> str:
    """Returns the fault in a message of drives, as words after `has`; empty: there is none."""
    edges, starts, ends = map(len, (drives.edges, drives.starts, drives.ends))
    if not edges == starts == ends:
        return f'{edges} edges, {starts} starts and {ends} ends; their numbers must be equal'
    if not all(map(isfinite, (*drives.starts, *drives.ends))):
        return 'times that are not finite'
    return ''


def _drives_of(drives: msg.PlannedDrives, rate: float) -> Tuple[PlannedDrive, ...]:
    return tuple(PlannedDrive(edge, start * rate, end * rate)
                 for edge, start, end in zip(drives.edges, drives.starts, drives.ends))


def _precedence_message(constraints: Sequence[Constraint]) -> msg.Precedence:
    numbers: Dict[str, int] = {}
    for one in constraints:
        numbers.setdefault(one.first, len(numbers))
        numbers.setdefault(one.then, len(numbers))
    return msg.Precedence(
        list(numbers), [numbers[one.first] for one in constraints],
        [one.before for one in constraints], [one.fraction for one in constraints],
        [numbers[one.then] for one in constraints], [one.drive for one in constraints])


def _constraints_of(order: msg.Precedence) -> Tuple[Constraint, ...]:
    """Returns the rules in a message. Raises WrongAnswer."""
    columns = order.before, order.before_drive, order.fraction, order.robot, order.drive
    lengths = set(map(len, columns))
    if len(lengths) > 1:
        raise WrongAnswer('the arrays of its precedence have different lengths')
    known = len(order.robots)
    if any(number >= known for number in (*order.before, *order.robot)):
        raise WrongAnswer(f'its precedence has {known} robots, but a rule names one more')
    return tuple(Constraint(order.robots[first], before, fraction, order.robots[then], drive)
                 for first, before, fraction, then, drive in zip(*columns))
