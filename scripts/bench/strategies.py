#!/usr/bin/env python3
"""Measures the time of two missions in the example laboratory, for each route strategy.

The bridge's route follower drives the simulated LD-90 on maps/lab.map from the dock and back to the
dock, in simulated time. So the figures do not depend on this computer. For the floor, the robot
drives to each destination on its own path, without a route, and need not pass the vertices between
the destinations. Each figure is the median of runs that begin at different moments between two
statuses of the robot. The strategy `rolling` was developed with the first mission. The second
mission visits other places and has fewer turns. It shows whether the result also holds for a
mission that was not used in development.
"""
from __future__ import annotations

import argparse
import math
import statistics
import sys
from pathlib import Path
from typing import List, NamedTuple, Sequence, Tuple

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'src/omron_ld90/test/bridge'))

from measuring.tables import print_table
from simulated_drive import DOCK_VERTEX, MAPS, STATUS_PERIOD, SimulatedDrive

from trajectory_graph import load_graph, route_vertices
from trajectory_graph.shortest_paths import shortest_route

MISSIONS = ((18, 39, 52, 6, DOCK_VERTEX), (35, 20, 27, 49, DOCK_VERTEX))
RUNS = 5
STRATEGIES = ('vertex_by_vertex', 'direct', 'rolling')
HEADINGS = ('strategy', 's', 'of vertex_by_vertex', 'commands', 'm off the curves, at most',
            'm from a vertex, at most')


class Drive(NamedTuple):
    """The results of one drive of the mission."""

    seconds: float
    commands: int
    farthest_from_route: float  # m
    farthest_from_vertex: float  # m


def drive(strategy: str, route: Sequence[int], delay: float) -> Drive:
    """Drives the route after a wait of `delay` seconds."""
    robot = SimulatedDrive(strategy)
    robot.wait(delay)
    seconds = robot.drive(1, *route)
    report = robot.follower.report()
    if report.reason:
        raise SystemExit(f'{strategy}: the route failed: {report.reason}')
    since, worst = 0, 0.0
    for vertex in route_vertices(robot.graph, route):
        if vertex != DOCK_VERTEX:
            away, since = robot.first_nearest_to(vertex, since)
            worst = max(worst, away)
    return Drive(seconds, len(robot.commands), robot.distance_from(tuple(route)), worst)


def drive_freely(mission: Sequence[int], delay: float) -> Drive:
    """Returns the floor: the robot gets each destination and chooses its own path."""
    robot = SimulatedDrive()
    robot.wait(delay)
    start = robot.now
    for vertex in mission:
        robot.send('dock' if vertex == DOCK_VERTEX else f'goto {vertex}')
    return Drive(robot.now - start, len(mission), float('nan'), float('nan'))


def median(drives: List[Drive]) -> Drive:
    """Returns a drive with the median of each figure."""
    return Drive(*(statistics.median(figures) for figures in zip(*drives)))


def table_of(mission: Sequence[int], route: Sequence[int]) -> List[Tuple[str, ...]]:
    """Returns one row for each strategy, and one for the floor."""
    delays = [STATUS_PERIOD * run / RUNS for run in range(RUNS)]
    found = {name: median([drive(name, route, delay) for delay in delays]) for name in STRATEGIES}
    found['floor: no route'] = median([drive_freely(mission, delay) for delay in delays])
    base = found['vertex_by_vertex'].seconds
    return [(name, f'{figures.seconds:.1f}', f'{100 * figures.seconds / base:.1f} %',
             f'{figures.commands:.0f}',
             *('' if math.isnan(away) else f'{away:.2f}'
               for away in (figures.farthest_from_route, figures.farthest_from_vertex)))
            for name, figures in found.items()]


def main() -> None:
    """Prints the tables."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    graph = load_graph(MAPS / 'lab_graph.yaml')
    for mission in MISSIONS:
        route = shortest_route(graph, (DOCK_VERTEX, *mission))
        length = sum(graph.curve(edge).length for edge in route)
        print(f'\nMission {", ".join(map(str, mission))} from the dock: {len(route)} edges, '
              f'{length:.0f} m; seconds of the robot, medians of {RUNS}.\n')
        print_table(table_of(mission, route), HEADINGS)


if __name__ == '__main__':
    main()
