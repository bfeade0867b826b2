"""Tasks, and what is made of them: `doTask`, `executeMacro` and `listExecute`.

A task is a script, as in `activities`; an instant task is over at once.
"""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Tuple

from omron_ld90.maps import MapDocument, MapObject
from omron_ld90_sim import activities
from omron_ld90_sim.kinematics import Pose, normalise
from omron_ld90_sim.robot import Robot
from omron_ld90_sim.states import STANDING, Activity, Failure, Script
from omron_ld90_sim.track import Turn, straight_track

LONGEST_MOVE = 100_000.0    # mm
SLOWEST_MOVE = 10.0         # mm/s
SPEECH = 12.0               # characters a second
SOUND = 2.0                 # s, how long every sound file is
_WORD = re.compile(r'"([^"]*)"|(\S+)')


def split_words(text: str) -> List[str]:
    """The words of a text, those in double quotes as one and without them."""
    return [m.group(1) if m.group(2) is None else m.group(2) for m in _WORD.finditer(text)]


class BadTask(ValueError):
    """No such task, or its arguments are wrong."""


@dataclass(frozen=True)
class Task:
    """A task with its arguments, as typed."""

    name: str
    rest: str

    def __str__(self) -> str:
        return f'{self.name} {self.rest}'.strip()

    @property
    def words(self) -> List[str]:
        """The arguments without quotes."""
        return split_words(self.rest)

    def number(self, index: int, default: Optional[float] = None) -> float:
        """The argument at `index`."""
        if index >= len(self.words) and default is not None:
            return default
        try:
            value = float(self.words[index])
        except (IndexError, ValueError):
            raise BadTask(f"Bad arguments for task '{self}'") from None
        if not math.isfinite(value):
            raise BadTask(f"Bad arguments for task '{self}'")
        return value


def parse(text: str) -> Task:
    """The task in `<task> <arguments>`; BadTask when there is none of that name."""
    name, _, rest = text.strip().partition(' ')
    task = Task(name, rest.strip())
    if name.lower() not in SCRIPTS and name.lower() not in INSTANT:
        raise BadTask(f"No task '{name}'")
    least, most = NUMBERS.get(name.lower(), (0, 0))
    for index in range(max(least, min(most, len(task.words)))):
        task.number(index)
    return task


def find_goal(document: MapDocument, name: str) -> Optional[MapObject]:
    """The goal with that name, in any case."""
    return next((goal for goal in document.goals if goal.name.lower() == name.lower()), None)


def script(robot: Robot, task: Task) -> Script:
    """Carries out one task, instant or not."""
    if task.name.lower() in INSTANT:
        INSTANT[task.name.lower()](robot, task)
        return
    yield from SCRIPTS[task.name.lower()](robot, task)


# -- the tasks -------------------------------------------------------------------------------

def _move(robot: Robot, task: Task) -> Script:
    distance, speed = task.number(0, 1000.0), task.number(1, 400.0)
    yield from activities.come_to_rest(robot)
    yield from activities.leave_dock(robot)
    if abs(distance) < 1.0:
        return
    if abs(distance) > LONGEST_MOVE or not robot.planner.straight_is_free(
            robot.true_pose, distance, robot.navigation.obstacles()):
        raise Failure('Failed to move', 'Failed to move')
    robot.follow([straight_track(robot.true_pose, distance, robot.base.limits,
                                 max(abs(speed), SLOWEST_MOVE))])
    yield STANDING


def _turn_to(robot: Robot, heading: float) -> Script:
    yield from activities.come_to_rest(robot)
    yield from activities.leave_dock(robot)
    if not robot.planner.can_turn(robot.true_pose, robot.navigation.obstacles()):
        raise Failure('Failed to turn', 'Failed to turn')
    robot.follow([Turn(normalise(heading), robot.base.limits.goal_rotation)])
    yield STANDING


def _delta_heading(robot: Robot, task: Task) -> Script:
    yield from activities.come_to_rest(robot)
    yield from _turn_to(robot, robot.true_pose.theta + task.number(0))


def _set_heading(robot: Robot, task: Task) -> Script:
    yield from _turn_to(robot, task.number(0))


def _go_to_point(robot: Robot, task: Task) -> Script:
    heading = normalise(task.number(2)) if len(task.words) > 2 else None
    yield from activities.go_to_point(robot, task.number(0), task.number(1), heading).script


def _go_to_goal(robot: Robot, task: Task) -> Script:
    goal = find_goal(robot.document, ' '.join(task.words[:1]))
    if goal is None:
        raise Failure('Failed going to goal', f'Failed going to {task.rest}')
    yield from activities.go_to_goal(robot, goal).script


def _wait(robot: Robot, task: Task) -> Script:
    seconds = max(task.number(0), 0.0)
    robot.waiting = ' '.join(task.words[1:]) or 'Waiting'
    robot.announce(f'WaitState: Waiting {seconds:g} seconds with status "{robot.waiting}"')
    try:
        end = robot.clock.now + seconds
        while robot.clock.now < end and robot.waiting:
            yield max(min(end - robot.clock.now, 0.1), 0.001)
        robot.announce('WaitState: Waiting completed' if robot.waiting
                       else 'WaitState: Waiting cancelled')
    except GeneratorExit:
        robot.announce('WaitState: Waiting interrupted')
        raise
    finally:
        robot.waiting = ''


def _pause(robot: Robot, task: Task) -> Script:
    robot.pausing = True
    robot.announce('PauseTask: pausing')
    try:
        while robot.pausing:
            yield 0.1
        robot.announce('PauseTask: cancelled')
    except GeneratorExit:
        robot.announce('PauseTask: interrupted')
        raise
    finally:
        robot.pausing = False


def _localize_at_goal(robot: Robot, task: Task) -> Script:
    goal = find_goal(robot.document, ' '.join(task.words[:1]))
    if goal is None:
        raise Failure('Robot lost', 'Robot lost')
    yield 1.0
    heading = goal.theta if goal.has_heading else robot.true_pose.theta
    robot.localize(Pose(goal.x, goal.y, heading))


def _say(robot: Robot, task: Task) -> Script:
    yield len(task.rest) / SPEECH


def _play(robot: Robot, task: Task) -> Script:
    yield SOUND


SCRIPTS: Dict[str, Callable[[Robot, Task], Script]] = {
    'move': _move, 'deltaheading': _delta_heading, 'setheading': _set_heading,
    'gotopoint': _go_to_point, 'goto': _go_to_goal, 'wait': _wait, 'pause': _pause,
    'localizeatgoal': _localize_at_goal, 'say': _say, 'play': _play,
}

# how many numbers a task needs and takes, checked before it begins
NUMBERS: Dict[str, Tuple[int, int]] = {
    'move': (0, 5), 'deltaheading': (1, 1), 'setheading': (1, 1), 'gotopoint': (2, 3),
    'wait': (1, 1), 'movementparameterstemp': (1, 1),
}


def _without_a_word(robot: Robot, task: Task) -> None:
    """What is heard or felt on the robot only: its tasks answer nothing (I617-E-02 p. 32, 74)."""


def _set_speed(robot: Robot, task: Task) -> None:
    """`movementParametersTemp`: its first argument is taken as the top speed (mm/s)."""
    speed = task.number(0)
    robot.navigation.speed_limit = speed if speed > 0 else None


def _block(robot: Robot, task: Task) -> None:
    robot.block('application', task.words[0] if task.words else '')


def _unblock(robot: Robot, task: Task) -> None:
    robot.unblock('application', task.words[0] if task.words else '')


INSTANT: Dict[str, Callable[[Robot, Task], None]] = {
    'sayinstant': _without_a_word, 'playinstant': _without_a_word,
    'movementparameterstemp': _set_speed, 'pathplanningsettingstemp': _without_a_word,
    'applicationblockdrivingset': _block, 'applicationblockdrivingclear': _unblock,
}


# -- activities made of tasks ----------------------------------------------------------------

def single(robot: Robot, task: Task) -> Activity:
    """`doTask`."""
    def run() -> Script:
        robot.announce(f'Doing task {task}')
        yield from script(robot, task)
        robot.status = robot.extended = f'Completed doing task {task}'
        robot.announce(robot.status)

    return Activity(f'Doing task {task}', f'Doing task {task}', run())


def macro(robot: Robot, name: str, tasks: List[Task]) -> Activity:
    """`executeMacro`."""
    def run() -> Script:
        robot.announce(f'Executing macro {name}')
        for task in tasks:
            yield from script(robot, task)
        robot.status = robot.extended = f'Completed macro {name}'
        robot.announce(robot.status)

    return Activity(f'Executing macro {name}', f'Executing macro {name}', run())


def task_list(robot: Robot, tasks: List[Task]) -> Activity:
    """`listExecute`."""
    def run() -> Script:
        robot.announce('Executing list')
        for task in tasks:
            yield from script(robot, task)
        robot.status = robot.extended = 'Successfully finished task list'
        robot.announce(robot.status)

    return Activity('Executing list', 'Executing list', run())
