"""Routes and macros from the map's `RouteInfo:` and `MacroInfo:` lines.

A line `Route "<name>"` or `Macro "<name>"` begins a route or a macro. Its lines `Goal "<goal>"` and
`Task "<task>" <arguments>` follow.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Tuple

from omron_ld90_sim.behaviour import activities, tasks
from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import ActivityFailure, Script, ScriptedActivity
from omron_ld90_sim.behaviour.task import RobotTask, find_goal, split_words
from omron_map import MapDocument


@dataclass(frozen=True)
class MapRoute:
    """A route: goals in order, and tasks to do at some of them."""

    name: str
    goals: Tuple[str, ...]
    tasks: Dict[int, List[RobotTask]]


def _blocks(document: MapDocument, keyword: str, head: str) -> List[Tuple[str, List[List[str]]]]:
    blocks: List[Tuple[str, List[List[str]]]] = []
    for record in document.records:
        text = record.raw.decode('utf-8', 'replace').strip()
        key, _, rest = text.partition(' ')
        if key.lower() != keyword.lower():
            continue
        words = split_words(rest)
        if words[:1] == [head] and len(words) > 1:
            blocks.append((words[1], []))
        elif words[:1] in (['Goal'], ['Task']) and blocks:
            blocks[-1][1].append([words[0], *words[1:]])
        else:
            blocks.append(('', []))     # another kind of block, to which the next lines belong
    return [block for block in blocks if block[0]]


def _task(words: List[str]) -> RobotTask:
    return RobotTask(words[0], ' '.join(f'"{w}"' if ' ' in w else w for w in words[1:]))


def routes(document: MapDocument) -> List[MapRoute]:
    """Returns the map's routes that have a goal, in file order."""
    found = []
    for name, rows in _blocks(document, 'RouteInfo:', 'Route'):
        goals: List[str] = []
        tasks: Dict[int, List[RobotTask]] = {}
        for kind, *words in rows:
            if kind == 'Goal' and words:
                goals.append(words[0])
            elif words and goals:
                tasks.setdefault(len(goals) - 1, []).append(_task(words))
        if goals:
            found.append(MapRoute(name, tuple(goals), tasks))
    return found


def macros(document: MapDocument) -> Dict[str, List[RobotTask]]:
    """Returns the map's macros by name, in file order."""
    return {name: [_task(words) for kind, *words in rows if kind == 'Task' and words]
            for name, rows in _blocks(document, 'MacroInfo:', 'Macro')}


def patrol(robot: SimRobot, route: MapRoute, once: bool, first: int = 0) -> ScriptedActivity:
    """Carries out `patrol` (without end) or `patrolOnce`, from the goal with index `first`.

    The goals on the way are not announced (ARCL manual I617-E-02 p. 161-166).
    """
    text = f'Patrolling route {route.name}' + (' once' if once else '')

    def run() -> Script:
        robot.announce(text)
        yield from activities.leave_dock(robot)
        start = first
        while True:
            for index in range(start, len(route.goals)):
                robot.tasks.patrol_places[route.name.lower()] = index
                robot.status = text
                goal = find_goal(robot.document, route.goals[index])
                if goal is None:
                    raise ActivityFailure('Failed going to goal',
                                          f'Failed going to {route.goals[index]}')
                yield from activities.pass_goal(robot, goal)
                for task in route.tasks.get(index, ()):
                    yield from tasks.script(robot, task)
            robot.tasks.patrol_places.pop(route.name.lower(), None)
            if once:
                break
            start = 0
            yield 0.0
        robot.status = robot.extended = f'Finished patrolling route {route.name}'
        robot.announce(robot.status)

    return ScriptedActivity(text, text, run())
