"""Tasks, macros and routes: what `doTask`, `executeMacro`, `listExecute` and `patrol` carry out.

A task is a script, as in `activities`; an instant task is over at once. Routes and macros come
from the map's `RouteInfo:` and `MacroInfo:` lines: `Route "<name>"` or `Macro "<name>"`, then its
`Goal "<goal>"` and `Task "<task>" <arguments>` lines.
"""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Tuple

from omron_ld90.maps import MapDocument, MapObject
from omron_ld90_sim import activities
from omron_ld90_sim.kinematics import Pose, normalise
from omron_ld90_sim.robot import STANDING, Activity, Failure, Robot, Script
from omron_ld90_sim.track import Turn, straight_track

_WORD = re.compile(r'"([^"]*)"|(\S+)')


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
        return [m.group(1) if m.group(2) is None else m.group(2)
                for m in _WORD.finditer(self.rest)]

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
    if not robot.planner.straight_is_free(robot.true_pose, distance, robot.dynamic_obstacles()):
        raise Failure('Failed to move', 'Failed to move')
    robot.base.follow([straight_track(robot.true_pose, distance, robot.base.limits, abs(speed))])
    yield STANDING


def _turn_to(robot: Robot, heading: float) -> Script:
    yield from activities.come_to_rest(robot)
    if not robot.planner.can_turn(robot.true_pose, robot.dynamic_obstacles()):
        raise Failure('Failed to turn', 'Failed to turn')
    robot.base.follow([Turn(normalise(heading), robot.base.limits.goal_rotation)])
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
    status = ' '.join(task.words[1:]) or 'Waiting'
    whole = f'{seconds:g}'
    robot.waiting = f'Waiting {whole} seconds with status "{status}"'
    robot.announce(f'WaitState: {robot.waiting}')
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


SCRIPTS: Dict[str, Callable[[Robot, Task], Script]] = {
    'move': _move, 'deltaheading': _delta_heading, 'setheading': _set_heading,
    'gotopoint': _go_to_point, 'goto': _go_to_goal, 'wait': _wait, 'pause': _pause,
    'localizeatgoal': _localize_at_goal,
}


# how many numbers a task needs and takes, checked before it begins
NUMBERS: Dict[str, Tuple[int, int]] = {
    'move': (0, 5), 'deltaheading': (1, 1), 'setheading': (1, 1), 'gotopoint': (2, 3),
    'wait': (1, 1), 'movementparameterstemp': (1, 1),
}


def _say(robot: Robot, task: Task) -> None:
    robot.announce(f'Saying {task.rest}')


def _play(robot: Robot, task: Task) -> None:
    robot.announce(f'Playing {task.rest}')


def _set_speed(robot: Robot, task: Task) -> None:
    """`movementParametersTemp`: its first argument is taken as the top speed (mm/s)."""
    speed = task.number(0)
    robot.speed_limit = speed if speed > 0 else None


def _block(robot: Robot, task: Task) -> None:
    robot.block(task.words[0] if task.words else '', ' '.join(task.words[1:]))


def _unblock(robot: Robot, task: Task) -> None:
    robot.block_reasons.pop(task.words[0] if task.words else '', None)


INSTANT: Dict[str, Callable[[Robot, Task], None]] = {
    'say': _say, 'sayinstant': _say, 'play': _play, 'playinstant': _play,
    'movementparameterstemp': _set_speed, 'pathplanningsettingstemp': lambda robot, task: None,
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


def patrol(robot: Robot, route: Route, once: bool, first: int = 0) -> Activity:
    """`patrol` without end, or `patrolOnce` from the goal with index `first`."""
    text = f'Patrolling route {route.name}' + (' once' if once else '')

    def run() -> Script:
        robot.announce(text)
        start = first
        while True:
            for index in range(start, len(route.goals)):
                robot.patrol_places[route.name.lower()] = index
                goal = find_goal(robot.document, route.goals[index])
                if goal is None:
                    raise Failure('Failed going to goal', f'Failed going to {route.goals[index]}')
                yield from activities.go_to_goal(robot, goal).script
                for task in route.tasks.get(index, ()):
                    yield from script(robot, task)
            robot.patrol_places.pop(route.name.lower(), None)
            if once:
                break
            start = 0
            yield 0.0
        robot.status = robot.extended = f'Finished patrolling route {route.name}'
        robot.announce(robot.status)

    return Activity(text, text, run())


# -- what the map knows ---------------------------------------------------------------------

@dataclass(frozen=True)
class Route:
    """A route: goals in order, and tasks to do at some of them."""

    name: str
    goals: Tuple[str, ...]
    tasks: Dict[int, List[Task]]


def _blocks(document: MapDocument, keyword: str, head: str) -> List[Tuple[str, List[List[str]]]]:
    blocks: List[Tuple[str, List[List[str]]]] = []
    for record in document.records:
        text = record.raw.decode('utf-8', 'replace').strip()
        key, _, rest = text.partition(' ')
        if key.lower() != keyword.lower():
            continue
        words = [m.group(1) if m.group(2) is None else m.group(2) for m in _WORD.finditer(rest)]
        if words[:1] == [head] and len(words) > 1:
            blocks.append((words[1], []))
        elif words[:1] in (['Goal'], ['Task']) and blocks:
            blocks[-1][1].append([words[0], *words[1:]])
        else:
            blocks.append(('', []))     # another kind of block: what follows belongs to it
    return [block for block in blocks if block[0]]


def _task(words: List[str]) -> Task:
    return Task(words[0], ' '.join(f'"{w}"' if ' ' in w else w for w in words[1:]))


def routes(document: MapDocument) -> List[Route]:
    """The map's routes, in file order."""
    found = []
    for name, rows in _blocks(document, 'RouteInfo:', 'Route'):
        goals: List[str] = []
        tasks: Dict[int, List[Task]] = {}
        for kind, *words in rows:
            if kind == 'Goal' and words:
                goals.append(words[0])
            elif words and goals:
                tasks.setdefault(len(goals) - 1, []).append(_task(words))
        found.append(Route(name, tuple(goals), tasks))
    return found


def macros(document: MapDocument) -> Dict[str, List[Task]]:
    """The map's macros by name, in file order."""
    return {name: [_task(words) for kind, *words in rows if kind == 'Task' and words]
            for name, rows in _blocks(document, 'MacroInfo:', 'Macro')}

