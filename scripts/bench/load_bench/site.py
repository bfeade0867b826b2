"""A site with thousands of edges, and its fleet, as files."""
from __future__ import annotations

from pathlib import Path
from typing import Dict, List, Tuple

from trajectory_graph import CurveType, Edge, Graph, Vertex, save_graph

SPACING = 2.5  # m between two vertices of a row or column
RELEASE_AHEAD = 4.0  # m


def grid(side: int) -> Graph:
    """So many rows and columns of vertices, each joined to the next."""
    vertices = [Vertex(side * row + column + 1, SPACING * column, SPACING * row, 0.0)
                for row in range(side) for column in range(side)]
    pairs = [(vertex.id, vertex.id + step) for vertex in vertices for step, is_inside in (
        (1, vertex.id % side), (side, vertex.id <= side * (side - 1))) if is_inside]
    return Graph(vertices, [Edge(id, one, other, CurveType.LINE, 0.0, 0.0, 1.0, 1.0)
                            for id, (one, other) in enumerate(pairs, 1)])


def starts(graph: Graph, robots: int) -> Dict[str, int]:
    """By the name of each robot the vertex at which it begins, spread evenly."""
    vertices: List[int] = list(graph.vertices)
    step = len(vertices) // robots
    return {f'agv_{k}': vertices[k * step] for k in range(robots)}


def save_site(folder: Path, side: int, robots: int) -> Tuple[Graph, Dict[str, int],
                                                            Dict[str, Path]]:
    """The graph, where the robots begin, and the files of both."""
    graph = grid(side)
    places = starts(graph, robots)
    files = {'graph': folder / 'graph.yaml', 'fleet': folder / 'fleet.yaml'}
    save_graph(graph, files['graph'])
    lines = ['clearance: 0.1', 'robot_types:',
             f'- {{name: agv, radius: 0.43, speed: 1.0, release_ahead: {RELEASE_AHEAD}}}',
             'robots:']
    lines += [f'- {{name: {name}, type: agv, vertex: {vertex}, driver: agv}}'
              for name, vertex in places.items()]
    files['fleet'].write_text('\n'.join(lines) + '\n')
    return graph, places, files
