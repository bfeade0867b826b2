"""CPU time of the supervisor's decisions for 200 robots that report 10 times a second.

It uses virtual time, the real planner and no ROS. Nothing is received or sent. The journal
is a temporary file.
"""
from __future__ import annotations

import statistics
import time
from random import Random
from typing import Callable, Dict, Iterator, List, Sequence, TypeVar

from measuring.tables import Row

from fleet_core.fleet import RobotType
from fleet_core.supervision.missions import Request
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.report_times import Rhythm
from fleet_simulation.virtual_fleet import VirtualFleet
from load_bench.site import RELEASE_AHEAD, grid, starts
from world.plain_agv import Agv

ROBOTS, SIDE = 200, 71
OPEN = 1000  # open missions
SETTLING, MEASURED = 8.0, 10.0  # virtual s
QUIET = 40  # ticks without any report
KIND = RobotType('agv', 0.43, 1.0)
Answer = TypeVar('Answer')


class _Fleet:
    """The fleet, its open missions, and the seconds that each kind of event has taken."""

    def __init__(self) -> None:
        graph = grid(SIDE)
        self.world = VirtualFleet(
            graph, {name: (KIND, vertex) for name, vertex in starts(graph, ROBOTS).items()},
            lambda _, kind, vertex: Agv(graph, kind, vertex),
            settings=RobotSettings(release_ahead=RELEASE_AHEAD), planning=0.3,
            rhythm=Rhythm(room=1e9), check_every=10 ** 9)
        self.spent: Dict[str, List[float]] = {}
        self._vertices, self._random, self._sent = sorted(graph.vertices), Random(1), 0
        supervisor = self.world.supervisor
        for owner, name in ((supervisor, 'report'), (supervisor, 'tick'),
                            (supervisor, 'plan_made'), (self.world.planner, 'plan')):
            setattr(owner, name, self._timed(name, getattr(owner, name)))

    def _timed(self, name: str, act: Callable[..., Answer]) -> Callable[..., Answer]:
        def timed(*values: object) -> Answer:
            begun = time.process_time()
            answer = act(*values)
            self.spent.setdefault(name, []).append(time.process_time() - begun)
            return answer
        return timed

    def run(self, seconds: float) -> None:
        """Simulates the fleet for `seconds` virtual seconds; replaces missions that end."""
        end = self.world.now + seconds - 1e-6
        while self.world.now < end:
            self.world.step()
            self._send(OPEN - len(self.world.supervisor.book.open))

    def _send(self, count: int) -> None:
        requests = [Request(self._sent + number, tuple(self._random.sample(self._vertices, 2)))
                    for number in range(1, count + 1)]
        self._sent += len(requests)
        if requests:
            self.world.do(self.world.supervisor.requests(requests, self.world.now))


def decisions() -> Iterator[Row]:
    """Measures reports, ticks, plans, and ticks without a report since the tick before."""
    fleet = _Fleet()
    fleet.run(SETTLING)
    fleet.spent.clear()
    fleet.run(MEASURED)
    spent, fleet.spent = fleet.spent, {}
    for number in range(QUIET):
        fleet.world.supervisor.tick(fleet.world.now + 0.05 * number)
    what = f'{ROBOTS} robots, 10 reports a second each, {OPEN} missions'
    for name, told in (('report', 'one report'), ('tick', 'one tick, all have reported'),
                       ('plan_made', 'one new plan taken into use'), ('plan', 'one plan made')):
        yield Row(f'{what}: {told}', _shown(spent.get(name, [])))
    yield Row(f'{what}: one tick without any news', _shown(fleet.spent['tick']))


def _shown(seconds: Sequence[float]) -> str:
    if not seconds:
        return 'none'
    return (f'median {1e3 * statistics.median(seconds):.3g} ms, mean '
            f'{1e3 * statistics.mean(seconds):.3g} ms of {len(seconds)}')
