"""The command line of `omron_ros_map`: graph + base map -> map, without a ROS master.

Exit status: 0 when the map is written, 1 when it could not be made, 2 for wrong arguments.
"""
from __future__ import annotations

import argparse
import sys
from typing import Callable, List, Optional

from omron_ld90.graph.converter import (
    Conversion,
    ConversionError,
    ExistingGoals,
    Options,
    convert_file,
)
from omron_ld90.maps import MapError
from trajectory_graph import TrajectoryGraphError, load_graph

#: What can be wrong with the files and options; the text of each is one sentence for people.
ERRORS = (ConversionError, MapError, TrajectoryGraphError)


def main(arguments: Optional[List[str]] = None) -> int:
    """Run the command and return its exit status."""
    chosen = _parser().parse_args(arguments)
    options = Options(
        dock_vertex=chosen.dock_vertex, dock_heading=chosen.dock_heading,
        existing_goals=ExistingGoals(chosen.existing_goals))
    try:
        run(chosen.graph, chosen.base_map, chosen.output, options, say=print,
            warn=lambda text: print(f'warning: {text}', file=sys.stderr))
    except ERRORS as error:
        print(f'error: {error}', file=sys.stderr)
        return 1
    return 0


def run(graph_file: str, base_map: str, output: str, options: Options,
        say: Callable[[str], object], warn: Callable[[str], object]) -> Conversion:
    """Convert files and tell what was done; raises one of ERRORS."""
    conversion = convert_file(load_graph(graph_file), base_map, output, options)
    for note in conversion.notes:
        warn(note)
    for line in report(conversion, output):
        say(line)
    return conversion


def report(conversion: Conversion, output: str) -> List[str]:
    """What was done, as lines for people."""
    places = conversion.added + conversion.kept
    goals = [obj for obj in places if obj.is_goal]
    lines = [f'{output}: {len(goals)} goals, '
             f'{sum(obj.has_heading for obj in goals)} of them with heading'
             + (f'; {len(conversion.kept)} were there already' if conversion.kept else '')
             + (f'; {len(conversion.removed)} removed or replaced' if conversion.removed else '')]
    lines += [f'dock {obj.label}: {obj.kind} at {obj.x:.0f} {obj.y:.0f} mm, facing its station at '
              f'{obj.theta:.1f} degrees' for obj in places if obj.is_dock]
    return lines


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='omron_ros_map', description='Writes the vertices of a trajectory graph into a .map '
        'file, as goals and dock.')
    parser.add_argument('--graph', required=True, metavar='G.yaml', help='trajectory graph')
    parser.add_argument('--base-map', required=True, metavar='M.map',
                        help='map made with MobilePlanner')
    parser.add_argument('--output', required=True, metavar='OUT.map', help='map to write')
    parser.add_argument('--dock-vertex', type=int, metavar='ID',
                        help='vertex at which the robot docks; without it there is no dock')
    parser.add_argument('--dock-heading', type=float, metavar='DEG',
                        help='heading that faces the station; by default from the graph')
    parser.add_argument('--existing-goals', default=ExistingGoals.REPLACE.value,
                        choices=[choice.value for choice in ExistingGoals],
                        help='goals and docks of the base map: replace those named like a vertex '
                        'and keep the others (default), keep all, or drop all')
    return parser
