#!/usr/bin/env python3
"""How long the mission 18, 39, 52, 6, 16 of the example laboratory takes, by strategy.

The bridge's route follower drives the simulated LD-90 on maps/lab.map from the dock and home again,
in simulated time, so the figures do not depend on this computer. The floor is the robot sent to the
five destinations by itself, without a route: what no way of driving the route can beat. Each figure
is the median of runs that differ in when the robot's status falls.
"""
from __future__ import annotations

import argparse
import statistics
import sys
from pathlib import Path
from typing import List, NamedTuple, Sequence, Tuple

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'src/omron_ld90/test/bridge'))

from simulated_drive import DOCK_VERTEX, MAPS, STATUS_PERIOD, SimulatedDrive, shortest_route

from trajectory_graph import load_graph, route_vertices

MISSION = (18, 39, 52, 6, DOCK_VERTEX)
RUNS = 5
STRATEGIES: Tuple[Tuple[str, dict], ...] = (
    ('vertex_by_vertex', {}), ('direct', {}), ('rolling', {}))


class Drive(NamedTuple):
    """What one drive of the mission came to."""

    seconds: float
    commands: int
    farthest_from_route: float  # m
    farthest_from_vertex: float  # m


def drive(strategy: str, settings: dict, route: Sequence[int], delay: float) -> Drive:
    """Drives the route after waiting `delay` seconds."""
    robot = SimulatedDrive(strategy, **settings)
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
    return Drive(seconds, len(robot.commands), robot.distance_from(route), worst)


def drive_freely(delay: float) -> Drive:
    """The floor: the robot is sent to each destination, and left to itself."""
    robot = SimulatedDrive()
    robot.wait(delay)
    start = robot.now
    for vertex in MISSION:
        robot.send('dock' if vertex == DOCK_VERTEX else f'goto {vertex}')
    return Drive(robot.now - start, len(MISSION), float('nan'), float('nan'))


def median(drives: List[Drive]) -> Drive:
    """The median of each figure."""
    return Drive(*(statistics.median(figures) for figures in zip(*drives)))


def main() -> None:
    """Prints the table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument('--markdown', action='store_true', help='print a Markdown table')
    markdown = options.parse_args().markdown
    graph = load_graph(MAPS / 'lab_graph.yaml')
    route = shortest_route(graph, (DOCK_VERTEX, *MISSION))
    length = sum(graph.curve(edge).length for edge in route)
    delays = [STATUS_PERIOD * run / RUNS for run in range(RUNS)]
    rows = [(name, median([drive(name, settings, route, delay) for delay in delays]))
            for name, settings in STRATEGIES]
    rows.append(('floor: no route', median([drive_freely(delay) for delay in delays])))
    print(f'Mission {", ".join(map(str, MISSION))} from the dock: {len(route)} edges, '
          f'{length:.0f} m; seconds of the robot, medians of {RUNS}.\n')
    table = [('strategy', 's', 'of vertex_by_vertex', 'commands', 'm off the curves, at most',
              'm from a vertex, at most')]
    base = rows[0][1].seconds
    for name, figures in rows:
        table.append((name, f'{figures.seconds:.0f}', f'{100 * figures.seconds / base:.0f} %',
                      f'{figures.commands:.0f}', f'{figures.farthest_from_route:.2f}',
                      f'{figures.farthest_from_vertex:.2f}'))
    table = [tuple('' if cell == 'nan' else cell for cell in row) for row in table]
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    for index, row in enumerate(table):
        line = ' | '.join(cell.ljust(width) for cell, width in zip(row, widths))
        print(f'| {line} |' if markdown else line.replace(' | ', '  '))
        if index == 0 and markdown:
            print('|' + '|'.join('-' * (width + 2) for width in widths) + '|')


if __name__ == '__main__':
    main()
