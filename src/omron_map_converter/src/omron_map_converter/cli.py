"""The command line of `omron_ros_map`: graph + base map -> map, without a ROS master.

Exit status: 0 if the map is written, 1 if it could not be made, 2 for wrong arguments.
"""
from __future__ import annotations

import argparse
import sys
from typing import Callable, List, Optional

from omron_map import MapDocument, MapError
from omron_map_converter.converter import (
    Conversion,
    ConversionError,
    ConversionOptions,
    ExistingGoals,
    convert_file,
)
from omron_map_converter.corridors import ROBOT_HALF_DIAGONAL, ROBOT_HALF_WIDTH, CorridorRules
from omron_map_converter.fences import Fences
from omron_map_converter.picture import draw
from trajectory_graph import TrajectoryGraphError, load_graph

WIDEST = 10000.0  # mm
#: Errors of the files and options; the text of each is one sentence for a person.
ERRORS = (ConversionError, MapError, TrajectoryGraphError)


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the command and returns its exit status."""
    chosen = _parser().parse_args(arguments)
    try:
        options = ConversionOptions(
            dock_vertex=chosen.dock_vertex, dock_heading=chosen.dock_heading,
            existing_goals=ExistingGoals(chosen.existing_goals), fences=Fences(chosen.fences),
            corridors=corridor_rules(chosen.corridor_width, chosen.edge_width,
                                     chosen.turning_margin))
        run(chosen.graph, chosen.base_map, chosen.output, options, say=print,
            warn=lambda text: print(f'warning: {text}', file=sys.stderr), picture=chosen.draw)
    except ERRORS as error:
        print(f'error: {error}', file=sys.stderr)
        return 1
    return 0


def run(graph_file: str, base_map: str, output: str, options: ConversionOptions,
        say: Callable[[str], object], warn: Callable[[str], object],
        picture: Optional[str] = None) -> Conversion:
    """Converts files and reports the result; raises one of ERRORS.

    `picture` is a PNG file into which the result is drawn.
    """
    graph = load_graph(graph_file)
    conversion = convert_file(graph, base_map, output, options)
    for note in conversion.notes:
        warn(note)
    for line in report(conversion, output):
        say(line)
    if picture:
        draw(MapDocument.load(output), graph, conversion, picture)
    return conversion


def corridor_rules(width: float, edge_widths: str, margin: float) -> CorridorRules:
    """Makes the rules from widths and margin in m; `edge_widths` is like `3=1.2 7=0.8`.

    Raises ConversionError, which names the option, for values that make no corridor.
    """
    by_edge = {}
    for item in edge_widths.replace(',', ' ').split():
        try:
            edge, own = item.split('=')
            by_edge[int(edge)] = 1000.0 * float(own)
        except ValueError:
            raise ConversionError(f'edge_width {item!r} is not like 3=1.2, which gives edge 3 a '
                                  'corridor of 1.2 m.') from None
    for value in (1000.0 * width, *by_edge.values()):
        if not 2.0 * ROBOT_HALF_WIDTH < value <= WIDEST:
            raise ConversionError(f'A corridor of {value / 1000.0:g} m is impossible: the robot is '
                                  f'{2 * ROBOT_HALF_WIDTH / 1000.0:g} m wide, and a corridor '
                                  f'has at most {WIDEST / 1000.0:g} m.')
    if not 0.0 <= margin <= 1.0:
        raise ConversionError(f'turning_margin is {margin:g}, but must lie in 0..1 m.')
    return CorridorRules(1000.0 * width, by_edge, ROBOT_HALF_DIAGONAL + 1000.0 * margin)


def report(conversion: Conversion, output: str) -> List[str]:
    """Returns the result of a conversion as lines for a person."""
    goals = [obj for obj in conversion.places if obj.is_goal]
    lines = [f'{output}: {len(goals)} goals, '
             f'{sum(obj.has_heading for obj in goals)} of them with heading; '
             f'{len(conversion.fences)} fences; {len(conversion.added)} objects added, '
             f'{len(conversion.removed)} removed']
    lines += [f'dock {obj.label}: {obj.kind} at {obj.x:.0f} {obj.y:.0f} mm, facing its station at '
              f'{obj.theta:.1f} degrees' for obj in conversion.places if obj.is_dock]
    return lines


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='omron_ros_map', description='Writes a trajectory graph into a .map file: vertices as '
        'goals and dock, fences along the edges.')
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
    parser.add_argument('--fences', default=Fences.AREAS.value,
                        choices=[choice.value for choice in Fences],
                        help='what keeps the robot in the corridors along the edges: forbidden '
                        'areas (default), forbidden lines, or nothing')
    parser.add_argument('--corridor-width', type=float, default=0.9, metavar='M',
                        help='width of the corridors in m (default %(default)s)')
    parser.add_argument('--edge-width', default='', metavar='ID=M,...',
                        help='widths of single edges, e.g. 3=1.2,7=0.8')
    parser.add_argument('--turning-margin', type=float, default=0.05, metavar='M',
                        help='free floor around the turning robot in m (default %(default)s)')
    parser.add_argument('--draw', metavar='OUT.png', help='picture of the result to draw')
    return parser
