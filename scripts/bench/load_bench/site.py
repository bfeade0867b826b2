"""The files of a site with thousands of edges, and the files of its fleet.

Nearly all robots share a grid. Each other robot has a ring that no other robot enters, so it waits
only for the fleet manager.
"""
from __future__ import annotations

import math
from pathlib import Path
from typing import Dict, List, NamedTuple, Sequence, Tuple

from trajectory_graph import CurveType, Edge, Graph, Vertex, save_graph

SPACING = 2.5  # m between two vertices of a row, column or ring
RING = 24  # vertices of a ring
RINGS = 10  # number of rings with one robot each
ALONE = 'alone_'  # prefix of the name of a robot on a ring
RELEASE_AHEAD = 4.0  # m


class Site(NamedTuple):
    """The graph, the robots' starts, the vertices of the grid and of each ring, and the files."""

    graph: Graph
    places: Dict[str, int]
    grid: List[int]
    rings: Dict[str, List[int]]
    files: Dict[str, Path]


def grid(side: int) -> Graph:
    """Returns a grid with `side` rows and columns, in which neighbours are joined."""
    vertices = [Vertex(side * row + column + 1, SPACING * column, SPACING * row, 0.0)
                for row in range(side) for column in range(side)]
    pairs = [(vertex.id, vertex.id + step) for vertex in vertices for step, is_inside in (
        (1, vertex.id % side), (side, vertex.id <= side * (side - 1))) if is_inside]
    return Graph(vertices, _edges(1, pairs))


def with_rings(graph: Graph) -> Tuple[Graph, Dict[str, List[int]]]:
    """Returns the graph with rings beside it, and the vertices of each ring by robot name."""
    vertices = list(graph.vertices.values())
    pairs: List[Tuple[int, int]] = []
    rings: Dict[str, List[int]] = {}
    radius = SPACING * RING / math.tau
    for number in range(RINGS):
        first = len(vertices) + 1
        ring = rings[f'{ALONE}{number}'] = list(range(first, first + RING))
        x, y = -4.0 * radius, 3.0 * radius * number
        vertices += [Vertex(id, x + radius * math.cos(math.tau * k / RING),
                            y + radius * math.sin(math.tau * k / RING), 0.0)
                     for k, id in enumerate(ring)]
        pairs += zip(ring, ring[1:] + ring[:1])
    return Graph(vertices, [*graph.edges.values(), *_edges(len(graph.edges) + 1, pairs)]), rings


def _edges(first: int, pairs: Sequence[Tuple[int, int]]) -> List[Edge]:
    return [Edge(id, one, other, CurveType.LINE, 0.0, 0.0, 1.0, 1.0)
            for id, (one, other) in enumerate(pairs, first)]


def starts(graph: Graph, robots: int) -> Dict[str, int]:
    """Returns the start vertices by robot name. They are spread evenly."""
    vertices: List[int] = list(graph.vertices)
    step = len(vertices) // robots
    return {f'agv_{k}': vertices[k * step] for k in range(robots)}


def save_site(folder: Path, side: int, robots: int, doors: int = 0) -> Site:
    """Writes the site for `robots` robots in all, with `doors` doors on the grid."""
    shared = grid(side)
    graph, rings = with_rings(shared)
    places = {**starts(shared, robots - RINGS), **{name: ring[0] for name, ring in rings.items()}}
    files = {'graph': folder / 'graph.yaml', 'fleet': folder / 'fleet.yaml'}
    save_graph(graph, files['graph'])
    lines = ['clearance: 0.1', 'robot_types:',
             f'- {{name: agv, radius: 0.43, speed: 1.0, release_ahead: {RELEASE_AHEAD}}}',
             'robots:']
    lines += [f'- {{name: {name}, type: agv, vertex: {vertex}, driver: agv}}'
              for name, vertex in places.items()]
    files['fleet'].write_text('\n'.join(lines) + '\n')
    if doors:
        files['work'] = folder / 'work.yaml'
        step = len(shared.edges) // doors
        files['work'].write_text('devices:\n' + ''.join(
            f'- {{name: door_{k}, kind: door, edges: [{edge}], timeout: 30, driver: simulated}}\n'
            for k, edge in enumerate(list(shared.edges)[step // 2::step][:doors], 1)))
    return Site(graph, places, list(shared.vertices), rings, files)
