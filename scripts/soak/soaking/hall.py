"""A generated hall for LD-90s and AGVs: graph, map and fleet file."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Tuple

from fleet_bench.instances import aisles
from scale_bench.hall import map_text

from soaking.work import work_file
from trajectory_graph import Graph, save_graph

CLEARANCE = 0.1
LD90_RADIUS, AGV_RADIUS = 0.43, 0.35
TYPES = f'''clearance: {CLEARANCE}
robot_types:
- {{name: ld90, radius: {LD90_RADIUS}, speed: 1.35, play: 0.25, obeys_edge_speed: false,
   release_ahead: 8.0, slack: 0.3}}
- {{name: agv, radius: {AGV_RADIUS}, speed: 1.0}}
robots:
'''


@dataclass(frozen=True)
class Hall:
    """The site on which the robots drive.

    stations -- ids of the vertices that missions visit
    radii    -- radii (m) of the robots, by name
    folder   -- folder with the files of the hall
    """

    graph: Graph
    stations: List[int]
    radii: Dict[str, float]
    folder: Path

    @property
    def places(self) -> Dict[int, Tuple[float, float]]:
        """Positions (m) of all vertices, by id."""
        return {id: vertex.position for id, vertex in self.graph.vertices.items()}

    @property
    def words(self) -> List[str]:
        """Arguments of `fleet_launch` for the hall."""
        return [f'{key}:={self.folder / name}' for key, name in (
            ('fleet', 'site_fleet.yaml'), ('graph_file', 'site_graph.yaml'),
            ('base_map', 'base.map'), ('work_file', 'site_work.yaml'))]


def write_hall(folder: Path, ld90s: int, agvs: int, plc_port: int) -> Hall:
    """Writes the files of a hall, which has at least 1.5 stations per robot."""
    count = ld90s + agvs
    size = 40
    graph, stations = aisles(size)
    while len(stations) < 1.5 * count:
        size += 5
        graph, stations = aisles(size)
    save_graph(graph, folder / 'site_graph.yaml')
    (folder / 'base.map').write_text(map_text(graph))
    edges = sorted(graph.edges)
    (folder / 'site_work.yaml').write_text(work_file(edges[len(edges) // 2], plc_port))
    names = [*(f'ld90_{k}' for k in range(1, ld90s + 1)), *(f'agv_{k}' for k in range(1, agvs + 1))]
    kinds = [name.split('_')[0] for name in names]
    (folder / 'site_fleet.yaml').write_text(TYPES + ''.join(
        f'- {{name: {name}, type: {kind}, vertex: {vertex}, driver: {kind}}}\n'
        for name, kind, vertex in zip(names, kinds, stations)))
    radii = {name: LD90_RADIUS if kind == 'ld90' else AGV_RADIUS
             for name, kind in zip(names, kinds)}
    return Hall(graph, stations, radii, folder)
