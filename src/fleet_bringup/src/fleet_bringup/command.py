"""`fleet_launch`: makes the files of a fleet, and prints the path of the launch file to start.

    fleet_launch [--print] fleet:=N|FILE [name:=value ...]

It needs no ROS master. The path of the launch file is the only line on stdout. With `--print` the
content of the files is printed instead. Exit status 0: done; 1: the fleet cannot be started, with
one sentence that says why.
"""
from __future__ import annotations

import os
import shutil
import sys
import tempfile
from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Sequence, Tuple

import rospkg

from fleet_bringup.errors import CannotStart
from fleet_bringup.files import StartedSite, make_site, simulated_robots
from fleet_bringup.launch_file import launch_text
from fleet_bringup.made_fleet import fleet_text, made_fleet, parking_places
from fleet_bringup.options import Options, help_text, parse
from fleet_bringup.ports import check_ports, needed_ports
from fleet_bringup.robot_entries import LD90, RobotEntry, check_count, read_entries
from fleet_bringup.rviz_file import rviz_text
from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.work_file import load_work
from fleet_core.fleet import Fleet
from trajectory_graph import Graph, GraphError, load_graph, split_edges


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if '-h' in words or '--help' in words:
        print(f'{__doc__}\nArguments:\n{help_text()}')
        return 0
    shown = '--print' in words
    folder = tempfile.mkdtemp(prefix='fleet_')
    try:
        options = parse([word for word in words if word != '--print'])
        files = prepare(options, folder, check=not shown)
    except (CannotStart, FileError, GraphError) as error:
        shutil.rmtree(folder)
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        shutil.rmtree(folder)
        raise
    if shown:
        _show(files)
        shutil.rmtree(folder)
    else:
        print(files['launch'])
    return 0


def _show(files: Dict[str, str]) -> None:
    for name in ('launch', 'fleet', 'robots'):
        if name in files:
            with open(files[name], encoding='utf-8') as stream:
                print(f'# --- {files[name]}\n{stream.read()}')
    print(f'# --- {files["rviz"]}: the RViz configuration')


def prepare(options: Options, folder: str, check: bool = True) -> Dict[str, str]:
    """Writes all files into a folder. Returns their paths by the kind of file.

    With `check`, a port in use is an error. Raises CannotStart, FileError, GraphError.
    """
    gathered = gather(options, folder, check)
    files = gathered.files
    if all(entry.is_simulated for entry in gathered.entries):  # a simulation keeps no closed edges
        files['closed_edges'] = os.path.join(folder, 'closed_edges.json')
        files['journal'] = os.path.join(folder, 'fleet.sqlite')
        files['page'] = os.path.join(folder, 'page')
        files['device_memory'] = os.path.join(folder, 'devices.json')
        files['device_steps'] = os.path.join(folder, 'device_steps.json')
    files['rviz'] = write_file(folder, 'fleet.rviz', rviz_text(gathered.entries, options))
    files['launch'] = write_file(folder, 'fleet.launch', launch_text(
        gathered.entries, gathered.site, options, files))
    return files


@dataclass(frozen=True)
class Gathered:
    """The inputs of launch files. `files`: paths by the kind of file."""

    entries: List[RobotEntry]
    site: StartedSite
    files: Dict[str, str]


def gather(options: Options, folder: str, check: bool = True) -> Gathered:
    """Writes graph, map, fleet file and the simulator's robots into a folder; see `prepare`."""
    laboratory = laboratory_folder(rospkg.RosPack().get_path('omron_ld90'))
    graph_file = options.graph_file or os.path.join(laboratory, 'lab_graph.yaml')
    whole = load_graph(graph_file)
    graph = split_edges(whole, options.longest_edge) if options.longest_edge > 0.0 else whole
    files = {'simulator_password': os.path.join(
        rospkg.RosPack().get_path('omron_ld90_sim'), 'config', 'simulator_password')}
    fleet, files['fleet'] = _fleet(options, folder, whole)
    entries = read_entries(files['fleet'], fleet, options)
    if check:
        check_ports(needed_ports(entries, options))
    site = _with_work(_site(options, folder, graph, entries, laboratory), options, laboratory)
    if any(entry.robot.driver == LD90 and entry.is_simulated for entry in entries):
        files['robots'] = write_file(folder, 'robots.yaml', simulated_robots(entries, graph))
    return Gathered(entries, site, files)


def laboratory_folder(package: str) -> str:
    """Returns the folder with the map and the graph of the laboratory. It is in the folder of the
    installed package omron_ld90, or at the top of the repository.
    """
    installed = os.path.join(package, 'maps')
    return installed if os.path.isdir(installed) else os.path.join(package, '..', '..', 'maps')


def _fleet(options: Options, folder: str, graph: Graph) -> Tuple[Fleet, str]:
    """Returns the fleet and the path of its file.

    graph -- the graph before its long edges are divided, because no robot parks where an edge is
             divided
    """
    if options.fleet.isdigit():
        count = int(options.fleet)
        if count == 0:
            raise CannotStart('fleet:=0 gives no robots: choose at least 1.')
        fleet = made_fleet(count, graph)
        return fleet, write_file(folder, 'fleet.yaml', fleet_text(fleet))
    path = options.fleet
    fleet = load_fleet(path)
    for robot in fleet.robots:
        if robot.vertex not in graph.vertices:
            raise CannotStart(f'{path}: robot {robot.name} stands on vertex {robot.vertex}, which '
                              'the graph does not have; choose another.')
    docks = sum(vertex.dock for vertex in graph.vertices.values())
    places = parking_places(graph, fleet.types, fleet.clearance, len(fleet.robots) - docks)
    check_count(fleet, len(places) + docks, path)
    return fleet, path


def _site(options: Options, folder: str, graph: Graph, entries: List[RobotEntry],
          laboratory: str) -> StartedSite:
    """Returns the graph and the map as files; raises CannotStart if LD-90s have no map."""
    base_map, map_file = options.base_map, options.map_file
    if not any(entry.robot.driver == LD90 for entry in entries):
        base_map = ''
    elif not base_map and not map_file:
        if options.graph_file:
            raise CannotStart('The LD-90s have no map: give base_map:=FILE, a .map file from which '
                              'theirs is made, or map_file:=FILE, a finished .map file.')
        base_map = os.path.join(laboratory, 'lab_base.map')
    return make_site(folder, graph, base_map, map_file)


def _with_work(site: StartedSite, options: Options, laboratory: str) -> StartedSite:
    """Returns the site with its work file. Raises FileError if the work file is wrong."""
    path = os.path.join(laboratory, 'lab_work.yaml') if options.work else options.work_file
    if not path:
        return site
    work = load_work(path, site.graph)
    return replace(site, work_file=path, has_devices=bool(work.devices or work.step_devices))


def write_file(folder: str, name: str, text: str) -> str:
    """Writes a text file; returns its path."""
    path = os.path.join(folder, name)
    with open(path, 'w', encoding='utf-8') as stream:
        stream.write(text)
    return path
