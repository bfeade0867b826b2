"""The graph, the map and the simulator's robots for one start, as files in one folder."""
from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence

import yaml

from fleet_bringup.errors import CannotStart
from fleet_bringup.robot_entries import LD90, RobotEntry
from omron_map import MapError
from omron_map_converter.converter import ConversionError, ConversionOptions, ExistingGoals
from omron_map_converter.fences import Fences
from omron_map_converter.kept_maps import convert_or_copy, folder_of_this_user
from trajectory_graph import Graph, save_graph


@dataclass(frozen=True)
class StartedSite:
    """The graph, the map and the work of the fleet, as files.

    map_file    -- empty if there are no LD-90s
    work_file   -- empty: there is none
    has_devices -- whether the work file has devices
    """

    graph: Graph
    graph_file: str
    map_file: str
    work_file: str = ''
    has_devices: bool = False

    @property
    def dock(self) -> int:
        """The id of the dock that LD-90s use; 0: none."""
        return next((one.id for one in self.graph.vertices.values() if one.dock), 0)


def make_site(folder: str, graph: Graph, base_map: str, map_file: str) -> StartedSite:
    """Writes the graph, and makes the map from the base map; raises CannotStart."""
    graph_file = os.path.join(folder, 'graph.yaml')
    save_graph(graph, graph_file)
    site = StartedSite(graph, graph_file, map_file)
    if not base_map:
        return site
    output = os.path.join(folder, 'fleet.map')
    try:
        convert_or_copy(graph, base_map, output,
                        ConversionOptions(dock_vertex=site.dock or None,
                                          existing_goals=ExistingGoals.REPLACE,
                                          fences=Fences.AREAS), folder_of_this_user())
    except (ConversionError, MapError) as error:
        raise CannotStart(
            f'The map of the LD-90s cannot be made from {base_map}: {error}') from None
    return StartedSite(graph, graph_file, output)


def simulated_robots(entries: Sequence[RobotEntry], graph: Graph) -> str:
    """Returns the content of the file for `ld90_sim --robots`."""
    rows: List[Dict[str, Any]] = []
    for entry in entries:
        if entry.robot.driver != LD90 or not entry.is_simulated:
            continue
        row: Dict[str, Any] = {'name': entry.name, 'port': entry.arcl_port,
                               'outgoing': f'127.0.0.1:{entry.outgoing_port}'}
        start = entry.start or _pose_on(graph, entry.robot.vertex)
        if start is not None:
            row['start'] = list(start)
        rows.append(row)
    return yaml.safe_dump({'robots': rows}, sort_keys=False, default_flow_style=None)


def _pose_on(graph: Graph, vertex: int) -> Optional[Sequence[float]]:
    """Returns the pose on a vertex, with the heading of the first edge that leads away from it.

    None for a dock: the simulator itself places a robot in its dock.
    """
    place = graph.vertex(vertex)
    ways = graph.edges_from(vertex)
    if place.dock or not ways:
        return None
    return (round(place.x, 3), round(place.y, 3),
            round(math.degrees(graph.curve(ways[0]).heading_at(0.0)), 1))
