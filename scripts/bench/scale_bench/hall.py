"""A hall for a given number of LD-90s: graph, map and fleet file."""
from __future__ import annotations

from pathlib import Path
from typing import Dict

from fleet_bench.instances import aisles

from trajectory_graph import Graph, save_graph

MARGIN = 3.0  # m from the graph to the walls
PITCH = 100  # mm between two points of a wall
PROBE = 'probe'


def write_hall(folder: Path, robots: int, probe_port: int, password_file: Path) -> Dict[str, str]:
    """Writes the files of the hall. Returns the arguments of `scripts/run.sh`.

    The probe is a robot that the benchmark plays. The fleet manager is told that the probe is
    absent, so that it does not wait for the probe.
    """
    graph, stations = aisles(max(150, 6 * robots))
    save_graph(graph, folder / 'graph.yaml')
    (folder / 'base.map').write_text(map_text(graph))
    step = len(stations) // robots
    rows = [f'- {{name: ld90_{k}, type: ld90, vertex: {vertex}, driver: ld90}}'
            for k, vertex in enumerate(stations[:robots * step:step], 1)]
    free = next(vertex for vertex in graph.vertices if vertex not in stations)
    rows.append(f'- {{name: {PROBE}, type: ld90, vertex: {free}, driver: ld90, absent: true, '
                f'host: 127.0.0.1, arcl_port: 9, outgoing_port: {probe_port}, '
                f'password_file: {password_file}}}')
    (folder / 'fleet.yaml').write_text('\n'.join([
        'clearance: 0.1', 'robot_types:',
        '- {name: ld90, radius: 0.43, speed: 1.35, play: 0.25, obeys_edge_speed: false, '
        'release_ahead: 8.0, slack: 0.3}', 'robots:', *rows]) + '\n')
    return {'fleet': str(folder / 'fleet.yaml'), 'graph_file': str(folder / 'graph.yaml'),
            'base_map': str(folder / 'base.map')}


def map_text(graph: Graph) -> str:
    """Returns the map of an empty hall."""
    xs = [vertex.x for vertex in graph.vertices.values()]
    ys = [vertex.y for vertex in graph.vertices.values()]
    left, right = (round(1000 * x) for x in (min(xs) - MARGIN, max(xs) + MARGIN))
    low, high = (round(1000 * y) for y in (min(ys) - MARGIN, max(ys) + MARGIN))
    walls = sorted([(left, low, right, low), (left, low, left, high),
                    (left, high, right, high), (right, low, right, high)])
    points = sorted({*((x, y) for x in range(left, right + 1, PITCH) for y in (low, high)),
                     *((x, y) for y in range(low, high + 1, PITCH) for x in (left, right))})
    return '\n'.join([
        '2D-Map', f'MinPos: {left} {low}', f'MaxPos: {right} {high}', f'NumPoints: {len(points)}',
        'PointsAreSorted: true', 'Resolution: 20', f'LineMinPos: {left} {low}',
        f'LineMaxPos: {right} {high}', f'NumLines: {len(walls)}', 'LinesAreSorted: true',
        'LINES', *(' '.join(map(str, wall)) for wall in walls),
        'DATA', *(f'{x} {y}' for x, y in points)]) + '\n'
