#!/usr/bin/env python3
"""What becomes of a late fleet: the fixed order of use, planning anew every 5 s, and switching.

Virtual hours of fleets that are always busy, the same seeds for each rival; `no stalls` is the
fixed order with robots that never stand still: more than that no order can win back. `--only
SECTION` runs one fleet, `--seeds N` seeds of it.
"""
from __future__ import annotations

import argparse
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Tuple

from fleet_bench.instances import aisles
from measuring.tables import print_table

from fleet_simulation.batch import Job, Progress, run_all
from fleet_simulation.demand import Demand, Flow, Saturated
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays, Standstill
from fleet_simulation.figures import Figures, Use
from fleet_simulation.site import Order, Site, site_of
from fleet_simulation.statistics import Band, band
from graph_fleet_manager.fleet import Fleet, Robot, RobotType
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import load_graph, split_edges

ROOT = Path(__file__).resolve().parents[2]
DOCK = 16
STATIONS = (6, 18, 27, 39, 52, DOCK)
PARKING = (8, 10, 14, 32, 33, 35, 41, 18, 27, 39, 52, 6, DOCK)
NEVER = Standstill(0.0, 0.0)
STALLS = Delays(1.1, Standstill(800.0, 20.0), NEVER)
AT_EDGE_SPEED = RobotType('agv', 0.43, 10.0, docks=frozenset((DOCK,)))
AGV = RobotType('agv', 0.35, 1.0, 0.0, False)


class Case(NamedTuple):
    """A fleet on its site, the virtual hours of a run, and how many runs."""

    site: Callable[[], Site]
    robots: int
    hours: float
    seeds: int


def laboratory() -> Site:
    """Sections of 1.5 m, nothing released ahead, missions to a station or the dock."""
    graph = split_edges(load_graph(ROOT / 'maps/lab_graph.yaml'), 1.5)
    robots = tuple(Robot(f'r{k}', AT_EDGE_SPEED, vertex, 'agv')
                   for k, vertex in enumerate(PARKING[:8]))
    settings = {robot.name: RobotSettings(release_ahead=0.0) for robot in robots}
    site = site_of(graph, Fleet((AT_EDGE_SPEED,), robots, 0.1), settings, busy(STATIONS))
    return replace(site, parking=PARKING)


def warehouse() -> Site:
    """Aisles with stations, 500 vertices."""
    graph, stations = aisles(500)
    return site_of(graph, Fleet((AGV,), (Robot('agv', AGV, stations[0], 'agv'),), 0.1),
                   {'agv': RobotSettings(release_ahead=2.0)}, busy(tuple(stations)))


def busy(targets: Tuple[int, ...]) -> Wanted:
    """One open mission for each robot, all the time."""
    return Wanted(Demand((Flow('all', (), targets, Saturated()),)), STALLS, {}, {})


SECTIONS: Dict[str, Case] = {
    'laboratory': Case(laboratory, 8, 1.0, 8),
    '50': Case(warehouse, 50, 0.1, 6),
}
RIVALS: Dict[str, Callable[[Site], Site]] = {
    'fixed order': lambda site: site,
    'planning anew every 5 s': lambda site: replace(site, order=Order.REPLANNING),
    'switching': lambda site: replace(site, order=Order.SWITCHING),
    'fixed order, no stalls': lambda site: replace(site, delays=replace(STALLS, stall=NEVER)),
}


def waiting(run: Figures) -> float:
    """Share (0..1) of the robots' time."""
    return run.use[Use.WAITING] / sum(run.use.values())


def change(values: List[float], of: List[float]) -> str:
    """By how much, seed by seed, with its 95 % band."""
    mean = sum(of) / len(of)
    found: Band = band([100.0 * (value - one) / mean for value, one in zip(values, of)])
    return f'{found.mean:+.1f} %' + (f' ± {found.half:.1f}' if found.half < inf else '')


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--only', choices=SECTIONS, help='run only this section')
    parser.add_argument('--seeds', type=int, default=0, help='how many, instead of its own number')
    parser.add_argument('--jobs', type=int, default=1, help='runs at once')
    options = parser.parse_args()
    rows = []
    for name in [options.only] if options.only else list(SECTIONS):
        case = SECTIONS[name]
        site = case.site()
        seeds = range(1, (options.seeds or case.seeds) + 1)
        jobs = [Job(rival, case.robots, seed, case.hours)
                for seed in seeds for rival in range(len(RIVALS))]
        done, _ = run_all([make(site) for make in RIVALS.values()], jobs, options.jobs,
                          Progress(name))
        runs = [[figures for job, figures in done if job.site == rival]
                for rival in range(len(RIVALS))]
        for rival, own in zip(RIVALS, runs):
            hourly, waits = [run.per_hour for run in own], [waiting(run) for run in own]
            rows.append((f'{case.robots} robots, {name}', rival, str(band(hourly)),
                         change(hourly, [run.per_hour for run in runs[0]]),
                         f'{100.0 * sum(waits) / len(waits):.1f} %',
                         change(waits, [waiting(run) for run in runs[0]]),
                         '; '.join(run.trouble for run in own if run.trouble)))
    print_table(rows, ('fleet', 'rival', 'missions an hour', 'against the fixed order', 'waiting',
                       'against the fixed order', 'trouble'))


if __name__ == '__main__':
    main()
