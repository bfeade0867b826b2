"""CPU time of first plans and replans of 200 robots on 5,000 vertices."""
from __future__ import annotations

import statistics
import time
from random import Random
from typing import Dict, Iterator, List, NamedTuple, Tuple

from measuring.tables import Row

from fleet_core.fleet import DOCK_APPROACH, Fleet, RobotType
from fleet_core.geometry.site_geometry import Alone
from fleet_core.planning.plan_requests import PlanRequest
from fleet_core.planning.plan_service import PlanService
from fleet_core.planning.tasks import PlannedDrive, Task
from load_bench.site import grid, starts

ROBOTS, SIDE = 200, 71
DOORS = 50
AT_ONCE = 10  # robots that get a destination at the same time
REPLANS = 20
LIMIT = 30.0  # s, the limit for one plan
KIND = RobotType('agv', 0.43, 1.0)


class _Answer(NamedTuple):
    seconds: float
    unserved: int


class _Site:
    """The robots, their tasks, and their present plans.

    doors -- number of edges on which only one robot may be at a time
    """

    def __init__(self, doors: int = 0) -> None:
        self.graph = grid(SIDE)
        self._alone = tuple(Alone(frozenset({edge})) for edge in (
            list(self.graph.edges)[::len(self.graph.edges) // doors][:doors] if doors else ()))
        self.goals: Dict[str, int] = {}
        self._service = PlanService(self.graph, Fleet((KIND,), (), 0.1, DOCK_APPROACH))
        self._service.prepare()
        self._parking = self._service.parking_by_name()
        self._places = starts(self.graph, ROBOTS)
        self._vertices = sorted(self.graph.vertices)
        self._random = Random(0)
        self._kept: Dict[str, Tuple[PlannedDrive, ...]] = {}

    def send(self, count: int, is_new: bool) -> None:
        """Gives new destinations to `count` robots: with `is_new` to robots without a destination,
        otherwise to robots that have one.
        """
        names = [name for name in self._places if (name in self.goals) != is_new]
        for name in self._random.sample(names, count):
            self.goals[name] = self._random.choice(self._vertices)
            self._kept.pop(name, None)

    def plan(self) -> _Answer:
        """Plans for all robots."""
        tasks = tuple(Task(name, KIND, vertex, kept=self._kept.get(name), destinations=(
            (self.goals[name],) if name in self.goals else ()))
            for name, vertex in self._places.items())
        begun = time.process_time()
        outcome = self._service.answer(PlanRequest(
            tasks, alone=self._alone, parking=self._parking, time_limit=LIMIT,
            improvement=0.0, seed=0))
        seconds = time.process_time() - begun
        self._kept = {name: tuple(drives) for name, drives in outcome.drives.items()
                      if name not in outcome.unserved}
        return _Answer(seconds, len(outcome.unserved))


def planning() -> Iterator[Row]:
    """Measures plans when some robots get destinations, and when all get them at once."""
    site = _Site()
    what = f'{ROBOTS} robots, {len(site.graph.vertices)} vertices, {len(site.graph.edges)} edges'
    first = site.plan()
    yield Row(f'{what}: first answer, no robot has a destination', f'{first.seconds:.2f} s', '', '')
    ramp: List[_Answer] = []
    while len(site.goals) < ROBOTS:
        site.send(AT_ONCE, True)
        ramp.append(site.plan())
    yield Row(f'{what}: {AT_ONCE} robots more get a destination, until all have one',
              _told(ramp), '', '')
    replans: List[_Answer] = []
    for _ in range(REPLANS):
        site.send(1, False)
        replans.append(site.plan())
    yield Row(f'{what}: one of them gets another destination', _told(replans), '', '')
    plain, doors = _all_at_once(0), _all_at_once(DOORS)
    yield Row(f'{what}: all get a destination at once', _told([plain]), '', '')
    yield Row(f'{what}: the same with {DOORS} doors, each for one robot at a time', _told([doors]),
              f'{plain.seconds:.2f} s without doors', '+10 %')


def _all_at_once(doors: int) -> _Answer:
    """Returns a plan in which all robots get their destinations at once."""
    site = _Site(doors)
    site.plan()
    site.send(ROBOTS, True)
    return site.plan()


def _told(answers: List[_Answer]) -> str:
    seconds = [answer.seconds for answer in answers]
    return (f'median {statistics.median(seconds):.2f} s, at most {max(seconds):.2f} s; unserved '
            f'{sum(answer.unserved for answer in answers)} of {len(answers)} plans')
