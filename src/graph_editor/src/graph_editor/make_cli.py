"""The command line of `make_graph`, which makes a trajectory graph from a map without a ROS master.

Exit status: 0 if the graph is written, 1 if it could not be made, 2 for wrong arguments.
"""
from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from typing import Callable, Dict, List, Optional, Tuple

from graph_editor.checking.checker import narrow_edges
from graph_editor.errors import SiteError
from graph_editor.graph_files import write_made_graph
from graph_editor.making.keeping_ids import with_ids_of
from graph_editor.making.maker import make_graph
from graph_editor.making.options import Halls, MakingOptions
from graph_editor.picture import draw_graph
from graph_editor.site import MappedSite, NamedPlace, PlaceKind, SiteOptions, load_site
from omron_map import MapError
from trajectory_graph import Graph, TrajectoryGraphError, load_graph

ERRORS = (SiteError, MapError, TrajectoryGraphError)
LoadMap = Callable[[str, SiteOptions], MappedSite]
_DEFAULT = MakingOptions()


def main(arguments: Optional[List[str]] = None, load: LoadMap = load_site) -> int:
    """Runs the command and returns its exit status; `load` reads the map of --map."""
    chosen = _parser().parse_args(arguments)
    try:
        options = MakingOptions(
            robot_width=chosen.robot_width, robot_length=chosen.robot_length,
            corridor=chosen.corridor, margin=chosen.margin, longest_edge=chosen.longest_edge,
            reach=chosen.reach, speed=chosen.speed, halls=Halls(chosen.halls),
            lattice_pitch=chosen.lattice_pitch)
        old = load_graph(chosen.keep_ids) if chosen.keep_ids else None
        site = load(chosen.map, site_options(chosen))
        site = replace(site, places=(*site.places, *_more_places(chosen)))
        made = make_graph(site, options)
        graph = made.graph if old is None else with_ids_of(old, made.graph)
        narrow = narrow_edges(graph, site.floor, options.corridor, options.robot_width)
        write_made_graph(graph, chosen.output, _comments(chosen.map, narrow, options),
                         chosen.force)
        for note in made.notes:
            print(f'warning: {note}', file=sys.stderr)
        for line in _report(chosen.output, graph, narrow, options):
            print(line)
        if chosen.draw:
            draw_graph(site, graph, chosen.draw, options.corridor)
    except ERRORS as error:
        print(f'error: {error}', file=sys.stderr)
        return 1
    return 0


def add_site_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options that name the map and the part of the map that is used."""
    parser.add_argument('--map', required=True, metavar='M', help="a robot's .map, the .yaml of a "
                        'ROS map, or topic:/map for a nav_msgs/OccupancyGrid that is published')
    parser.add_argument('--area', metavar='X1,Y1,X2,Y2', help='the part of the map that is used, m '
                        '(default: inside the scanned outline)')
    parser.add_argument('--outline-gap', type=float, default=SiteOptions.outline_gap, metavar='M',
                        help='gaps in the outline up to this width are closed (default '
                        '%(default)s)')
    parser.add_argument('--resolution', type=float, default=SiteOptions.resolution, metavar='M',
                        help='size of the cells into which a .map is divided (default '
                        '%(default)s)')


def add_robot_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options for the size of the robot and the width of its lanes."""
    parser.add_argument('--robot-width', type=float, default=_DEFAULT.robot_width, metavar='M',
                        help='(default %(default)s)')
    parser.add_argument('--robot-length', type=float, default=_DEFAULT.robot_length, metavar='M',
                        help='(default %(default)s)')
    parser.add_argument('--corridor', type=float, default=_DEFAULT.corridor, metavar='M',
                        help='width of a lane if there is enough space (default %(default)s)')


def site_options(chosen: argparse.Namespace) -> SiteOptions:
    """Returns the options from the arguments of `add_site_arguments`; raises SiteError."""
    area = None if chosen.area is None else area_of(chosen.area, '--area')
    if not 0.005 <= chosen.resolution <= 0.25:
        raise SiteError(f'--resolution is {chosen.resolution:g}, but must lie in 0.005..0.25 m.')
    if not 0.0 <= chosen.outline_gap <= 100.0:
        raise SiteError(f'--outline-gap is {chosen.outline_gap:g}, but must lie in 0..100 m.')
    return SiteOptions(area, chosen.outline_gap, chosen.resolution)


def area_of(text: str, option: str) -> Tuple[float, float, float, float]:
    """Returns the two corners (m) of a rectangle from their text; raises SiteError."""
    try:
        x1, y1, x2, y2 = (float(value) for value in text.split(','))
        if not math.isfinite(x1 + y1 + x2 + y2):
            raise ValueError
    except ValueError:
        raise SiteError(f'{option} is {text!r}, but must be two corners in m, like '
                        '-10,-5,20.5,8.') from None
    return x1, y1, x2, y2


def edge_width_option(narrow: Dict[int, float]) -> str:
    """Returns the option of `omron_ros_map` that gives the widths of narrow edges."""
    return '--edge-width ' + ','.join(f'{id}={width:.2f}' for id, width in sorted(narrow.items()))


def _more_places(chosen: argparse.Namespace) -> List[NamedPlace]:
    """Returns the docks and goals of the command line; raises SiteError."""
    places = [_place(PlaceKind.DOCK, f'dock,{text}', f'--dock {text}') for text in chosen.dock]
    return places + [_place(PlaceKind.GOAL, text, f'--goal {text}') for text in chosen.goal]


def _place(kind: PlaceKind, text: str, option: str) -> NamedPlace:
    try:
        name, *numbers = text.split(',')
        x, y, degrees = (float(number or 'nan') for number in numbers)
        if math.isfinite(x) and math.isfinite(y) and not math.isinf(degrees):
            heading = None if math.isnan(degrees) else math.radians(degrees)
            return NamedPlace(kind, name, x, y, heading)
        raise ValueError
    except ValueError:
        raise SiteError(f'{option} must give {"" if kind is PlaceKind.DOCK else "a name, "}x and y '
                        'in m and the heading in degrees, with commas between.') from None


def _comments(map_file: str, narrow: Dict[int, float], options: MakingOptions) -> List[str]:
    comments = [f'From {map_file}, in metres; check it with check_graph, change it in the editor.']
    if narrow:
        comments.append(f'Edges with no room for {options.corridor:g} m: omron_ros_map '
                        f'{edge_width_option(narrow)}')
    return comments


def _report(output: str, graph: Graph, narrow: Dict[int, float],
            options: MakingOptions) -> List[str]:
    length = sum(graph.curve(id).length for id in graph.edges)
    docks = [vertex.id for vertex in graph.vertices.values() if vertex.dock]
    parking = sum(bool(vertex.parking) for vertex in graph.vertices.values())
    lines = [f'{output}: {len(graph.vertices)} vertices and {len(graph.edges)} edges, '
             f'{length:.0f} m; {parking} parking places; '
             + (f'docks {", ".join(map(str, docks))}' if docks else 'no dock')]
    if narrow:
        lines.append(f'{len(narrow)} edges have no room for a corridor of {options.corridor:g} m; '
                     f'run omron_ros_map with {edge_width_option(narrow)}')
    return lines


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='make_graph', description='Makes a trajectory graph from a map: lanes in the middle '
        'of the free floor, goals and docks as vertices, parking places.')
    add_site_arguments(parser)
    parser.add_argument('--output', required=True, metavar='G.yaml', help='graph to write; a file '
                        'edited by hand is not overwritten')
    parser.add_argument('--force', action='store_true', help='overwrite an existing file')
    parser.add_argument('--keep-ids', metavar='OLD.yaml', help='older graph; its vertices and '
                        'edges keep their ids if they still exist')
    parser.add_argument('--draw', metavar='OUT.png', help='write a picture of the result')
    parser.add_argument('--dock', action='append', default=[], metavar='X,Y,DEG', help='a dock '
                        'that the map does not have: the position of robots before they dock, in '
                        'm, and the heading towards the station; write --dock=-3,2,180')
    parser.add_argument('--goal', action='append', default=[], metavar='NAME,X,Y,DEG',
                        help='a goal that the map does not have; DEG may be empty')
    add_robot_arguments(parser)
    parser.add_argument('--margin', type=float, default=_DEFAULT.margin, metavar='M',
                        help='free space beside robot and corridor (default %(default)s)')
    parser.add_argument('--longest-edge', type=float, default=_DEFAULT.longest_edge, metavar='M',
                        help='lanes that are longer are cut (default %(default)s)')
    parser.add_argument('--reach', type=float, default=_DEFAULT.reach, metavar='M',
                        help='largest distance of floor from the lanes; bays are added to keep it '
                        '(default %(default)s)')
    parser.add_argument('--speed', type=float, default=_DEFAULT.speed, metavar='M/S',
                        help='speed on wide straight lanes (default %(default)s)')
    parser.add_argument('--halls', default=_DEFAULT.halls.value,
                        choices=[choice.value for choice in Halls],
                        help='lanes of wide places: in the middle with bays (default), or a '
                        'lattice')
    parser.add_argument('--lattice-pitch', type=float, default=_DEFAULT.lattice_pitch, metavar='M',
                        help='distance between the lanes of a lattice (default %(default)s)')
    return parser
