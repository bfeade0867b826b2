#!/usr/bin/env python3
"""Compares three ways to order late robots on shared places: fixed, planned anew, and switched.

Each way is a *rival*. Fleets that always have open missions are simulated in virtual time, with the
same seeds for each rival. With the rival `no stalls` the order is fixed and robots never stall, so
its result is the upper limit for all others. `--only SECTION` runs one fleet; `--seeds N` sets the
number of seeds.
"""
from __future__ import annotations

import argparse
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Tuple

from fleet_bench.instances import aisles
from measuring.tables import print_table

from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.batch import Job, ProgressBar, run_all
from fleet_simulation.demand import Demand, Flow, Saturated
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays, RandomStops
from fleet_simulation.figures import Figures, Use
from fleet_simulation.site import OrderPolicy, StudiedSite, site_of
from fleet_simulation.statistics import Band, band
from trajectory_graph import load_graph, split_edges

ROOT = Path(__file__).resolve().parents[2]
DOCK = 16
STATIONS = (6, 18, 27, 39, 52, DOCK)
PARKING = (8, 10, 14, 32, 33, 35, 41, 18, 27, 39, 52, 6, DOCK)
NEVER = RandomStops(0.0, 0.0)
STALLS = Delays(1.1, RandomStops(800.0, 20.0), NEVER)
AT_EDGE_SPEED = RobotType('agv', 0.43, 10.0, docks=frozenset((DOCK,)))
AGV = RobotType('agv', 0.35, 1.0, 0.0, False)


class Case(NamedTuple):
    """A site, the number of robots, the virtual hours of a run, and the number of seeds."""

    site: Callable[[], StudiedSite]
    robots: int
    hours: float
    seeds: int


def laboratory() -> StudiedSite:
    """Returns the laboratory map, its edges cut into sections of at most 1.5 m. No edge is released
    ahead of a robot, and missions go to stations or the dock.
    """
    graph = split_edges(load_graph(ROOT / 'maps/lab_graph.yaml'), 1.5)
    robots = tuple(Robot(f'r{k}', AT_EDGE_SPEED, vertex, 'agv')
                   for k, vertex in enumerate(PARKING[:8]))
    settings = {robot.name: RobotSettings(release_ahead=0.0) for robot in robots}
    site = site_of(graph, Fleet((AT_EDGE_SPEED,), robots, 0.1), settings, busy(STATIONS))
    return replace(site, parking=PARKING)


def warehouse() -> StudiedSite:
    """Returns a made-up warehouse: aisles with stations, 500 vertices."""
    graph, stations = aisles(500)
    return site_of(graph, Fleet((AGV,), (Robot('agv', AGV, stations[0], 'agv'),), 0.1),
                   {'agv': RobotSettings(release_ahead=2.0)}, busy(tuple(stations)))


def busy(targets: Tuple[int, ...]) -> Wanted:
    """Returns a demand with one open mission per robot at any time."""
    return Wanted(Demand((Flow('all', (), targets, Saturated()),)), STALLS, {}, {})


SECTIONS: Dict[str, Case] = {
    'laboratory': Case(laboratory, 8, 1.0, 8),
    '50': Case(warehouse, 50, 0.1, 6),
}
RIVALS: Dict[str, Callable[[StudiedSite], StudiedSite]] = {
    'fixed order': lambda site: site,
    'planning anew every 5 s': lambda site: replace(site, order=OrderPolicy.REPLANNING),
    'switching': lambda site: replace(site, order=OrderPolicy.SWITCHING),
    'fixed order, no stalls': lambda site: replace(site, delays=replace(STALLS, stall=NEVER)),
}


def waiting(run: Figures) -> float:
    """Returns the share (0..1) of the robots' time in which they wait."""
    return run.use[Use.WAITING] / sum(run.use.values())


def change(values: List[float], of: List[float]) -> str:
    """Returns the change from `of` to `values` as a text, in % of the mean of `of`.

    The text has the mean of the changes of all seeds, and half the width of its 95 % confidence
    band.
    """
    mean = sum(of) / len(of)
    found: Band = band([100.0 * (value - one) / mean for value, one in zip(values, of)])
    return f'{found.mean:+.1f} %' + (f' ± {found.half:.1f}' if found.half < inf else '')


def main() -> None:
    """Runs the rivals and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--only', choices=SECTIONS, help='run only this fleet')
    parser.add_argument('--seeds', type=int, default=0,
                        help='number of seeds (0: the own number of each fleet)')
    parser.add_argument('--jobs', type=int, default=1, help='runs at the same time (1)')
    options = parser.parse_args()
    rows = []
    for name in [options.only] if options.only else list(SECTIONS):
        case = SECTIONS[name]
        site = case.site()
        seeds = range(1, (options.seeds or case.seeds) + 1)
        jobs = [Job(rival, case.robots, seed, case.hours)
                for seed in seeds for rival in range(len(RIVALS))]
        done, _ = run_all([make(site) for make in RIVALS.values()], jobs, options.jobs,
                          ProgressBar(name))
        runs = [[figures for job, figures in done if job.site == rival]
                for rival in range(len(RIVALS))]
        for rival, own in zip(RIVALS, runs):
            hourly, waits = [run.per_hour for run in own], [waiting(run) for run in own]
            rows.append((f'{case.robots} robots, {name}', rival, str(band(hourly)),
                         change(hourly, [run.per_hour for run in runs[0]]),
                         f'{100.0 * sum(waits) / len(waits):.1f} %',
                         change(waits, [waiting(run) for run in runs[0]]),
                         '; '.join(run.trouble for run in own if run.trouble)))
    print_table(rows, ('fleet', 'rival', 'missions per hour', 'change from the fixed order',
                       'share of waiting', 'change from the fixed order', 'trouble'))


if __name__ == '__main__':
    main()
