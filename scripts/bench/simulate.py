#!/usr/bin/env python3
"""Measures how fast the fleet simulation runs on one core, as a multiple of real time.

All fleets always have open missions. Times are processor times in one process, divided into world,
supervisor and planner. `--only SECTION` runs one case (see SECTIONS). `--profile` prints the
functions that take the most time.
"""
from __future__ import annotations

import argparse
import cProfile
import pstats
from pathlib import Path
from typing import Callable, Dict, NamedTuple

from fleet_bench.instances import aisles
from measuring.tables import print_table

from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.demand import Demand, Flow, Saturated
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays
from fleet_simulation.figures import Figures
from fleet_simulation.simulation import simulate
from fleet_simulation.site import StudiedSite, site_of
from trajectory_graph import load_graph, split_edges

ROOT = Path(__file__).resolve().parents[2]
LD90 = RobotType('ld90', 0.43, 1.35, 0.25, False, docks=frozenset((16,)))
AGV = RobotType('agv', 0.35, 1.0, 0.0, False)
SETTINGS = {'ld90': RobotSettings(release_ahead=8.0),
            'agv': RobotSettings(release_ahead=2.0)}


class Case(NamedTuple):
    """A site, the number of robots, the virtual hours of a run, and the aim (multiple of real
    time).
    """

    site: Callable[[], StudiedSite]
    robots: int
    hours: float
    aim: int


def laboratory() -> StudiedSite:
    """Returns the laboratory map with sections of at most 1.5 m; every second robot is an AGV."""
    graph = split_edges(load_graph(ROOT / 'maps/lab_graph.yaml'), 1.5)
    robots = (Robot('ld90', LD90, 8, 'ld90'), Robot('agv', AGV, 10, 'agv'))
    return site_of(graph, Fleet((LD90, AGV), robots, 0.1), SETTINGS, busy((6, 18, 27, 39, 52)))


def warehouse(vertices: int) -> StudiedSite:
    """Returns a made-up warehouse: aisles with stations, and AGVs."""
    graph, stations = aisles(vertices)
    return site_of(graph, Fleet((AGV,), (Robot('agv', AGV, stations[0], 'agv'),), 0.1),
                   SETTINGS, busy(tuple(stations)))


def busy(targets: tuple) -> Wanted:
    """Returns a demand with one open mission per robot at any time."""
    return Wanted(Demand((Flow('all', (), targets, Saturated()),)), Delays(), {}, {})


SECTIONS: Dict[str, Case] = {
    'laboratory': Case(laboratory, 8, 0.5, 600),
    '50': Case(lambda: warehouse(500), 50, 0.05, 130),
    '200': Case(lambda: warehouse(2000), 200, 0.01, 20),
}


def measured(name: str, profile: bool) -> Figures:
    """Runs one case. Returns its figures."""
    case = SECTIONS[name]
    site, watch = case.site(), cProfile.Profile()
    figures = (watch.runcall if profile else lambda act, *a: act(*a))(
        simulate, site, case.robots, 1, case.hours)
    if profile:
        pstats.Stats(watch).sort_stats('tottime').print_stats(30)
    return figures


def main() -> None:
    """Runs the cases and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--only', choices=SECTIONS, help='run only this case')
    parser.add_argument('--profile', action='store_true',
                        help='print the functions that take the time')
    options = parser.parse_args()
    rows = []
    for name in [options.only] if options.only else list(SECTIONS):
        figures = measured(name, options.profile)
        whole = sum(figures.spent)
        rows.append((f'{SECTIONS[name].robots} robots, {name}', f'{figures.speed:.1f} x',
                     *(f'{100 * part / whole:.0f} %' for part in figures.spent),
                     f'{figures.per_hour:.0f}', f'{SECTIONS[name].aim} x', figures.trouble))
    print_table(rows, ('case', 'times real time, one core', 'world', 'supervisor', 'planner',
                       'missions per hour', 'aim', 'trouble'))


if __name__ == '__main__':
    main()
