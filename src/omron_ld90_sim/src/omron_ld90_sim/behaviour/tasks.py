"""Tasks, and the activities made of them: `doTask`, `executeMacro` and `listExecute`.

A task is a script, as in `activities`; an instant task ends at once.
"""
from __future__ import annotations

import math
from typing import Callable, Dict, List, NamedTuple

from omron_ld90_sim.behaviour import activities
from omron_ld90_sim.behaviour.instant_tasks import INSTANT
from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import STANDING, ActivityFailure, Script, ScriptedActivity
from omron_ld90_sim.behaviour.task import BadTask, RobotTask, find_goal
from omron_ld90_sim.motion.kinematics import normalise
from omron_ld90_sim.motion.track import Turn, straight_track

LONGEST_LEG = 100_000.0     # mm, the longest part of a move that is planned at once
MINIMUM_SPEED = 10.0        # mm/s
MINIMUM_ROTATION = 1.0      # deg/s
LOOK_AGAIN = 1.0            # s between two checks whether the path of a move is free
SPEECH = 12.0               # characters per second
SOUND = 2.0                 # s, length of every sound file


class Arguments(NamedTuple):
    """The number of words that a task needs, and the positions of its numeric arguments."""

    required: int
    numbers: range = range(0)


ARGUMENTS: Dict[str, Arguments] = {     # checked before a task begins
    'move': Arguments(0, range(5)), 'deltaheading': Arguments(1, range(2)),
    'setheading': Arguments(1, range(1)), 'gotopoint': Arguments(2, range(3)),
    'goto': Arguments(1), 'wait': Arguments(1, range(1)), 'say': Arguments(1),
    'play': Arguments(1), 'sayinstant': Arguments(1), 'playinstant': Arguments(1),
    'movementparameterstemp': Arguments(2, range(1, 5)),
    'movementparameters': Arguments(2, range(1, 5)), 'arclsendtext': Arguments(1),
    'applicationfaultset': Arguments(3), 'applicationfaultclear': Arguments(1),
    'applicationblockdrivingset': Arguments(1), 'applicationblockdrivingclear': Arguments(1),
    'customoutputon': Arguments(1), 'customoutputoff': Arguments(1),
    'localizeatgoal': Arguments(1, range(1, 3)),
}


def parse(text: str) -> RobotTask:
    """Returns the task of a text `<task> <arguments>`; raises BadTask if the text is wrong."""
    name, _, rest = text.strip().partition(' ')
    task = RobotTask(name, rest.strip())
    if name.lower() not in SCRIPTS and name.lower() not in INSTANT:
        raise BadTask(f"No task '{name}'")
    wanted = ARGUMENTS.get(name.lower(), Arguments(0))
    if len(task.words) < wanted.required:
        raise task.bad_arguments()
    for index in wanted.numbers:
        if index < len(task.words):
            task.number(index)
    return task


def script(robot: SimRobot, task: RobotTask) -> Script:
    """Carries out one task, instant or not."""
    if task.name.lower() in INSTANT:
        INSTANT[task.name.lower()](robot, task)
        return
    yield from SCRIPTS[task.name.lower()](robot, task)


# -- the tasks -------------------------------------------------------------------------------

def _move(robot: SimRobot, task: RobotTask) -> Script:
    """Drives straight: `<mm> <mm/s> <front clearance> <side clearance> <s without progress after
    which it fails>`.
    """
    left, speed = task.number(0, 1000.0), max(abs(task.number(1, 400.0)), MINIMUM_SPEED)
    clearance, timeout = task.number(2, 200.0), task.number(4, 30.0)
    yield from activities.come_to_rest(robot)
    yield from activities.leave_dock(robot)
    waited = 0.0
    while abs(left) >= 1.0:
        here = robot.true_pose
        leg = _free_leg(robot, left, clearance)
        if leg:
            robot.executive.follow([straight_track(here, leg, robot.base.limits, speed)])
            yield STANDING
        driven = here.distance_to(robot.true_pose.x, robot.true_pose.y)
        if driven >= 1.0:
            left, waited = left - math.copysign(driven, left), 0.0
        elif waited >= timeout:
            raise ActivityFailure('Failed to move', 'Failed to move')
        else:
            yield LOOK_AGAIN
            waited += LOOK_AGAIN


def _free_leg(robot: SimRobot, distance: float, clearance: float) -> float:
    """Returns the part of `distance` (mm, negative: backwards) that can be driven straight on.

    It ends `clearance` mm before the first obstacle, and is at most LONGEST_LEG long.
    """
    here, obstacles = robot.true_pose, robot.navigation.obstacles()
    wanted = math.copysign(min(abs(distance), LONGEST_LEG), distance)

    def is_free(leg: float) -> bool:
        return robot.navigation.planner.straight_is_free(
            here, math.copysign(leg, wanted), obstacles)

    if is_free(abs(wanted)):
        return wanted
    free, blocked = 0.0, abs(wanted)
    while blocked - free > 10.0:
        middle = (free + blocked) / 2
        free, blocked = (middle, blocked) if is_free(middle) else (free, middle)
    return math.copysign(max(free - max(clearance, 0.0), 0.0), wanted)


def _turn(robot: SimRobot, turn: Callable[[], Turn]) -> Script:
    yield from activities.come_to_rest(robot)
    yield from activities.leave_dock(robot)
    if not robot.navigation.planner.can_turn(robot.true_pose, robot.navigation.obstacles()):
        raise ActivityFailure('Failed to turn', 'Failed to turn')
    robot.executive.follow([turn()])
    yield STANDING


def _delta_heading(robot: SimRobot, task: RobotTask) -> Script:
    """Turns by an angle: `<deg, left positive> <deg/s>`; the angle may exceed a whole turn."""
    limits, angle = robot.base.limits, task.number(0)
    wanted = abs(task.number(1, limits.goal_rotation))
    rate = min(max(wanted, MINIMUM_ROTATION), limits.path_rotation)
    yield from _turn(robot, lambda: Turn(normalise(robot.true_pose.theta + angle), rate, angle))


def _set_heading(robot: SimRobot, task: RobotTask) -> Script:
    """Turns to a heading, `<deg>`, in the shorter direction."""
    yield from _turn(robot, lambda: Turn(normalise(task.number(0)),
                                         robot.base.limits.goal_rotation))


def _go_to_point(robot: SimRobot, task: RobotTask) -> Script:
    heading = normalise(task.number(2)) if len(task.words) > 2 else None
    yield from activities.go_to_point(robot, task.number(0), task.number(1), heading).script


def _go_to_goal(robot: SimRobot, task: RobotTask) -> Script:
    goal = find_goal(robot.document, task.words[0])
    if goal is None:
        raise ActivityFailure('Failed going to goal', f'Failed going to {task.rest}')
    yield from activities.go_to_goal(robot, goal).script


def _wait(robot: SimRobot, task: RobotTask) -> Script:
    seconds = max(task.number(0), 0.0)
    robot.tasks.waiting = ''.join(task.words[1:2]) or 'Waiting'
    robot.announce(f'WaitState: Waiting {seconds:g} seconds with status "{robot.tasks.waiting}"')
    try:
        end = robot.clock.now + seconds
        while robot.clock.now < end and robot.tasks.waiting:
            yield max(min(end - robot.clock.now, 0.1), 0.001)
        robot.announce('WaitState: Waiting completed' if robot.tasks.waiting
                       else 'WaitState: Waiting cancelled')
    except GeneratorExit:
        robot.announce('WaitState: Waiting interrupted')
        raise
    finally:
        robot.tasks.waiting = ''


def _pause(robot: SimRobot, task: RobotTask) -> Script:
    robot.tasks.pausing = True
    robot.announce('PauseTask: pausing')
    try:
        while robot.tasks.pausing:
            yield 0.1
        robot.announce('PauseTask: cancelled')
    except GeneratorExit:
        robot.announce('PauseTask: interrupted')
        raise
    finally:
        robot.tasks.pausing = False


def _say(robot: SimRobot, task: RobotTask) -> Script:
    yield len(task.rest) / SPEECH


def _play(robot: SimRobot, task: RobotTask) -> Script:
    yield SOUND


SCRIPTS: Dict[str, Callable[[SimRobot, RobotTask], Script]] = {
    'move': _move, 'deltaheading': _delta_heading, 'setheading': _set_heading,
    'gotopoint': _go_to_point, 'goto': _go_to_goal, 'wait': _wait, 'pause': _pause,
    'say': _say, 'play': _play,
}


# -- activities made of tasks ----------------------------------------------------------------

def single(robot: SimRobot, task: RobotTask) -> ScriptedActivity:
    """Carries out `doTask`."""
    def run() -> Script:
        robot.announce(f'Doing task {task}')
        yield from script(robot, task)
        robot.status = robot.extended = f'Completed doing task {task}'
        robot.announce(robot.status)

    return ScriptedActivity(f'Doing task {task}', f'Doing task {task}', run())


def macro(robot: SimRobot, name: str, tasks: List[RobotTask]) -> ScriptedActivity:
    """Carries out `executeMacro`."""
    def run() -> Script:
        robot.announce(f'Executing macro {name}')
        try:
            for task in tasks:
                yield from script(robot, task)
        except ActivityFailure as failure:
            # after a failed macro the status is the same text as the announced line
            raise ActivityFailure(str(failure), f'Error: {failure}') from failure
        robot.status = robot.extended = f'Completed macro {name}'
        robot.announce(robot.status)

    return ScriptedActivity(f'Executing macro {name}', f'Executing macro {name}', run())


def task_list(robot: SimRobot, tasks: List[RobotTask]) -> ScriptedActivity:
    """Carries out `listExecute`."""
    def run() -> Script:
        robot.announce('Executing list')
        for task in tasks:
            yield from script(robot, task)
        robot.status = robot.extended = 'Successfully finished task list'
        robot.announce(robot.status)

    return ScriptedActivity('Executing list', 'Executing list', run())
