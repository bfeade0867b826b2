#!/usr/bin/env python3
"""Measures the fleet's planner: planning time, cost of the plans, and the number of missions done.

Every plan uses true sizes, speeds and conflict sets. Times are CPU times, because other work on the
machine hardly changes them. Time limits use the clock. The speed of a virtual machine changes from
minute to minute. So the section `stations` makes the first plans of all seeds in many turns, and
each turn also times a loop of additions. `--only SECTION` runs one part (see SECTIONS). Rivals are
installed from PyPI into virtual environments under build/rivals.
"""
from __future__ import annotations

import argparse
import statistics
import sys
import time
from pathlib import Path
from typing import Callable, Dict, Iterator, List, NamedTuple, Sequence, Tuple

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / 'src/fleet_core/test'))

from fleet_bench import operation, queueing, rivals  # noqa: E402
from fleet_bench.instances import (  # noqa: E402
    AGV,
    CLEARANCE,
    Instance,
    aisles,
    dense_moves,
    draw,
    sparse_roadmap,
)
from measuring.tables import print_table  # noqa: E402
from plan_checker import faults  # noqa: E402

from fleet_core.files.plan_file import solved_plan  # noqa: E402
from fleet_core.fleet import RobotType  # noqa: E402
from fleet_core.planning.layers import Search, layered  # noqa: E402
from fleet_core.planning.planner import FleetPlanner  # noqa: E402
from fleet_core.planning.road_network import RoadNetwork  # noqa: E402
from fleet_core.planning.safe_intervals import find_path  # noqa: E402
from fleet_core.planning.tasks import PlanningOutcome  # noqa: E402
from trajectory_graph import Graph, split_edges  # noqa: E402

SEEDS = 20
TURNS = 20
"""The number of times that the first plans of all seeds are made."""
Row = Tuple[str, str, str]
"""(label, figure, aim)."""


class Planned(NamedTuple):
    """One instance: seconds to a first plan, and the plan's cost (divided by its lower bound)."""

    seconds: float
    solved: bool
    ratio: float


def plan(base: RoadNetwork, instance: Instance, limit: float, search: Search = find_path,
         improve: bool = True) -> Planned:
    """Plans with newly computed heuristics and existing conflict sets."""
    planner = FleetPlanner(base.with_closed(()), CLEARANCE, [AGV], search=search)
    planner.prepare()
    begun = time.process_time()
    outcome = planner.plan(instance.tasks(), (), time.monotonic() + limit, 0)
    seconds = time.process_time() - begun
    if improve:
        outcome = planner.plan(instance.tasks(), (), time.monotonic() + limit)
    return Planned(seconds, not outcome.unserved, ratio(outcome))


def additions() -> float:
    """Returns the seconds for 300,000 additions in a loop, a measure of the machine's speed now."""
    begun = time.process_time()
    total = 0
    for number in range(300_000):
        total += number
    return time.process_time() - begun


def ratio(outcome: PlanningOutcome) -> float:
    """Returns the cost of the robots that are served, divided by its lower bound."""
    return outcome.cost / outcome.lower_bound if outcome.lower_bound else 1.0


def summary(planned: Sequence[Planned]) -> str:
    """Returns a text: the number of solved instances, the planning times, and the costs."""
    good = [p for p in planned if p.solved]
    if not good:
        return f'0 of {len(planned)}'
    milliseconds = [1e3 * p.seconds for p in good]
    ratios = [p.ratio for p in good]
    return (f'{len(good)} of {len(planned)}; first plan {statistics.median(milliseconds):.0f} ms, '
            f'at most {max(milliseconds):.0f} ms; {statistics.mean(ratios):.3f} x the lower bound, '
            f'at most {max(ratios):.3f}')


def stations() -> Iterator[Row]:
    """Measures instances whose stations are at the ends of spurs."""
    for vertices, robots, aim, bound in ((500, 50, '20 of 20 within 25 ms', '1.25 x'),
                                         (2000, 100, '20 of 20 within 150 ms', '1.08 x')):
        graph, ends = aisles(vertices)
        base = RoadNetwork(graph)
        instances = [draw(ends, robots, seed) for seed in range(SEEDS)]
        yield from first_plans(base, instances, f'{robots} robots, {vertices} vertices, stations',
                               aim)
        costs = [plan(base, instance, 1.0).ratio for instance in instances]
        yield ('the same, cost after 1 s', f'{statistics.mean(costs):.3f} x the lower bound, at '
               f'most {max(costs):.3f}', bound)


def first_plans(base: RoadNetwork, instances: Sequence[Instance], what: str,
                aim: str) -> Iterator[Row]:
    """Measures the time to a first plan: the usual time, and the time while the machine runs at
    full speed.
    """
    planned, floors = [], []
    for _ in range(TURNS):
        floors.append(1e3 * additions())
        planned.append([plan(base, instance, 1.0, improve=False) for instance in instances])
    times = [[1e3 * one.seconds for one in turns] for turns in zip(*planned)]
    usual, best = list(map(statistics.median, times)), list(map(min, times))
    yield (f'{what}: first plan, medians of {TURNS} turns',
           f'{sum(one.solved for one in planned[0])} of {len(instances)}; '
           f'{statistics.median(usual):.0f} ms, at most {max(usual):.0f} ms', aim)
    yield ('each in its quickest turn',
           f'{statistics.median(best):.1f} ms, at most {max(best):.1f} ms', aim)
    yield ('floor in each turn: 300,000 additions in a loop',
           f'{statistics.median(floors):.1f} ms ({min(floors):.1f} to {max(floors):.1f})', '')


def any_vertex() -> Iterator[Row]:
    """Measures the same fleets with goals at any vertices."""
    for vertices, robots in ((500, 50), (2000, 100)):
        graph = aisles(vertices)[0]
        base = RoadNetwork(graph)
        yield (f'{robots} robots, {vertices} vertices, any vertex: first plan, its cost',
               summary([plan(base, draw(list(graph.vertices), robots, seed), 1.0, improve=False)
                        for seed in range(SEEDS)]), '20 of 20 within 1 s')


def compared(anywhere: bool) -> Callable[[], Iterator[Row]]:
    """Returns a function that measures our planner and its rivals on the same instances.

    The same checker judges all plans. Goals are stations or, with `anywhere`, any vertices.
    """
    def section() -> Iterator[Row]:
        environments = {package: rivals.environment(package) for package in rivals.PACKAGES}
        for vertices, robots in ((500, 50), (2000, 100)):
            graph, ends = aisles(vertices)
            pool, name = ((list(graph.vertices), 'any vertex') if anywhere
                          else (ends, 'stations'))
            where = f'{robots} robots, {vertices} vertices, {name}'
            instances = [draw(pool, robots, seed) for seed in range(SEEDS)]
            base = RoadNetwork(graph)
            ours = [own(base, instance) for instance in instances]
            yield f'graph_fleet_manager, {where}', judged(ours), 'all that a rival solves'
            for solver in rivals.SOLVERS:
                python, why_not = environments[solver.split('/')[0]]
                if python is None:
                    yield f'{solver}, {where}', f'skipped: {why_not}', ''
                    continue
                found = rivals.run(solver, python, graph, instances, 1.0)
                ahead = sum(his.ratio is not None and mine.ratio is None
                            for his, mine in zip(found, ours))
                yield f'{solver}, {where}', judged(found), f'{ahead} that we do not solve'
    return section


def own(base: RoadNetwork, instance: Instance) -> rivals.Judged:
    """Makes our first plan, within a second. Returns the checker's judgement of the plan."""
    planner = FleetPlanner(base.with_closed(()), CLEARANCE, [AGV])
    planner.prepare()
    begun = time.monotonic()
    outcome = planner.plan(instance.tasks(), (), begun + 1.0, 0)
    seconds = time.monotonic() - begun
    if outcome.unserved:
        return rivals.Judged(seconds, False, None)
    wrong = faults(rivals.world_of(base.graph, instance), solved_plan(outcome, 0.0, 0.0))
    return rivals.Judged(seconds, seconds <= 1.0, None if wrong else ratio(outcome))


def judged(found: Sequence[rivals.Judged]) -> str:
    """Returns a text: the numbers of solved and of safe instances, the times, and the costs."""
    safe = [one.ratio for one in found if one.ratio is not None]
    cost = f', {statistics.mean(safe):.2f} x the lower bound' if safe else ''
    return (f'{sum(one.solved for one in found)} of {len(found)} in 1 s each, {len(safe)} of them '
            f'safe by the checker{cost}; median '
            f'{1e3 * statistics.median(one.seconds for one in found):.0f} ms')


def conflict_sets() -> Iterator[Row]:
    """Measures the time to compute the conflict sets of a graph."""
    for graph, what, aim in ((aisles(500)[0], '500 vertices', '50 ms'),
                             (dense_moves(2500, 7500), '15,000 drives', '1 s')):
        seconds = []
        for _ in range(5):
            begun = time.process_time()
            FleetPlanner(RoadNetwork(graph), CLEARANCE, [AGV]).prepare()
            seconds.append(time.process_time() - begun)
        yield (f'conflict sets, {what} ({len(graph.edges)} edges)',
               f'{1e3 * statistics.median(seconds):.0f} ms', aim)


def sparse() -> Iterator[Row]:
    """Measures a roadmap with long edges, before and after the edges are cut into sections."""
    for robots, longest, aim in ((30, None, '15 of 20 in 2 s, at most 2.2 x'),
                                 (20, 3.0, '20 of 20 in 2 s, at most 1.08 x')):
        planned = []
        for seed in range(SEEDS):
            whole = sparse_roadmap(seed)
            graph = whole if longest is None else split_edges(whole, longest)
            planned.append(plan_in(graph, draw(list(whole.vertices), robots, seed), 2.0))
        edges = 'whole edges' if longest is None else f'cut at {longest:.0f} m'
        yield f'sparse roadmap, 170 vertices, {robots} robots, {edges}', summary(planned), aim


def plan_in(graph: Graph, instance: Instance, limit: float) -> Planned:
    """Makes and improves a plan, both within `limit` s together."""
    planner = FleetPlanner(RoadNetwork(graph), CLEARANCE, [AGV])
    planner.prepare()
    begun = time.monotonic()
    outcome = planner.plan(instance.tasks(), (), begun + limit)
    return Planned(time.monotonic() - begun, not outcome.unserved, ratio(outcome))


def layers() -> Iterator[Row]:
    """Compares layers (TEA*) with safe intervals: both solve each instance, one after the other."""
    graph, ends = aisles(500)
    base = RoadNetwork(graph)
    for seconds in (1.0, 0.5):
        times: Dict[str, List[float]] = {'intervals': [], 'layers': []}
        costs: Dict[str, List[float]] = {'intervals': [], 'layers': []}
        for seed in range(SEEDS // 2):
            for name, search in (('intervals', find_path), ('layers', layered(seconds))):
                planned = plan(base, draw(ends, 50, seed), 30.0, search, improve=False)
                times[name].append(planned.seconds)
                costs[name].append(planned.ratio)
        fast, slow = (statistics.median(times[name]) for name in times)
        good, other = (statistics.mean(costs[name]) for name in costs)
        yield (f'first plan, 50 robots, 500 vertices: safe intervals beside layers of {seconds} s',
               f'{1e3 * fast:.0f} ms and {good:.3f} x beside {1e3 * slow:.0f} ms and {other:.3f} x '
               f'({slow / fast:.1f} times as fast)', 'same or better cost')


def replanning() -> Iterator[Row]:
    """Measures a large fleet at work, with delays and stalls; each end of a mission causes a plan.
    """
    graph, ends = aisles(500)
    figures, _ = operation.at_work(graph, AGV, ends[::2][:50], ends, 0, 300.0, 0)
    times = sorted(figures.planning)
    yield (f'replanning, 50 robots, 500 vertices, 300 s at work, {len(times)} plans, '
           f'{figures.succeeded} missions',
           f'median {1e3 * times[len(times) // 2]:.0f} ms, '
           f'p99 {1e3 * times[int(0.99 * len(times))]:.0f} ms', 'p99 200 ms')


def laboratory(robots: int, longest: float, kind: RobotType, seeds: int,
               aim: str) -> Callable[[], Iterator[Row]]:
    """Measures a simulated hour on the example laboratory's graph."""
    def section() -> Iterator[Row]:
        runs = [operation.in_the_laboratory(robots, longest, kind, seed) for seed in range(seeds)]
        edges = 'whole edges' if longest > 100.0 else f'sections of {longest} m'
        still = max(run.longest_standstill for _, run in runs)
        hourly = [figures.per_hour for figures, _ in runs]
        yield (f'laboratory, {robots} x {kind.name}, {edges}, 1 h',
               f'{statistics.median(hourly):.0f} missions an hour '
               f'({min(hourly):.0f} to {max(hourly):.0f}); '
               f'no robot drives for at most {still:.0f} s', aim)
    return section


def station_queues() -> Iterator[Row]:
    """Measures how many missions are done if robots wait for each other only at the stations."""
    found = [queueing.missions(8, seed) for seed in range(200)]
    yield ('laboratory, 8 robots that meet only at the dead ends of the stations, 200 seeds',
           f'{statistics.mean(found):.0f} missions on average ({min(found)} to {max(found)})',
           'what the graph allows')


WHOLE = 1e6
SECTIONS: Dict[str, Callable[[], Iterator[Row]]] = {
    'stations': stations, 'any_vertex': any_vertex,
    'rivals': compared(False), 'rivals_any_vertex': compared(True),
    'conflict_sets': conflict_sets, 'sparse': sparse, 'layers': layers, 'replanning': replanning,
    'lab_1': laboratory(1, WHOLE, operation.AGV, 3, 'floor: one robot alone'),
    'lab_8': laboratory(8, WHOLE, operation.AGV, 3, '260'),
    'station_queues': station_queues,
    'lab_8_sections': laboratory(8, 1.5, operation.AGV, 3, '380'),
    'lab_12': laboratory(12, WHOLE, operation.AGV, 1, 'never still for good'),
    'lab_8_ld90': laboratory(8, WHOLE, operation.LD90, 3, ''),
}


def main() -> None:
    """Prints the table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument('--only', choices=SECTIONS, action='append', help='run only these')
    chosen = options.parse_args()
    print_table((row for name in chosen.only or SECTIONS for row in SECTIONS[name]()),
                ('what', f'figure, {SEEDS} seeds where nothing else is said', 'aim'))


if __name__ == '__main__':
    main()
