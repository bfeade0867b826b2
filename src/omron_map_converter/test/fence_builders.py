"""Grids, and fences around the corridors of graphs."""
from __future__ import annotations

import math
from typing import List, Optional, Tuple

import numpy as np

from omron_map import MapObject
from omron_map_converter.corridors import CorridorRules, Corridors, corridors_of
from omron_map_converter.fences import Fences, fence_objects
from trajectory_graph import CurveType, Edge, Graph, Vertex

NO_WALLS = np.empty((0, 2))


def grid(columns: int, rows: int, pitch: float = 2.5, degrees: float = 0.0) -> Graph:
    """Returns a grid of straight edges, turned by `degrees`; neighbours are `pitch` m apart."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    vertices, ends = [], []
    for row in range(rows):
        for column in range(columns):
            id, x, y = 1 + row * columns + column, column * pitch, row * pitch
            vertices.append(Vertex(id, x * c - y * s, x * s + y * c, 0.0))
            ends += [(id, id + 1)] if column + 1 < columns else []
            ends += [(id, id + columns)] if row + 1 < rows else []
    return Graph(vertices, [Edge(id, *pair) for id, pair in enumerate(ends, 1)])


def quarter_turn(radius: float) -> Graph:
    """Returns a graph. Edge 1 is a quarter circle to the left, between two edges of 4 m."""
    # control length of the Bezier curve of that circle
    reach = radius * 4.0 / 3.0 * math.tan(math.pi / 8.0)
    return Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, radius, radius, math.pi / 2.0),
                  Vertex(3, -4.0, 0.0, 0.0), Vertex(4, radius, radius + 4.0, math.pi / 2.0)],
                 [Edge(1, 1, 2, CurveType.SPLINE, reach, reach), Edge(2, 3, 1), Edge(3, 2, 4)])


def fenced(graph: Graph, walls: np.ndarray = NO_WALLS, kind: Fences = Fences.AREAS,
           rules: Optional[CorridorRules] = None) -> Tuple[Corridors, List[MapObject]]:
    """Returns the corridors of a graph, and the fences around them as map objects."""
    corridors = corridors_of(graph, rules or CorridorRules())
    return corridors, fence_objects(corridors.floor, walls, kind)


def wall(x1: float, y1: float, x2: float, y2: float) -> np.ndarray:
    """Returns points (N,2) of a wall, one every 20 mm from end to end."""
    count = int(math.hypot(x2 - x1, y2 - y1) / 20.0) + 1
    return np.column_stack((np.linspace(x1, x2, count), np.linspace(y1, y2, count)))


def real_site_graph() -> Graph:
    """Returns a graph for the real map `omron-ld-site-a`: corridors of 1.2 m, halls, a diagonal."""
    places = {1: (-5.0, -0.8), 2: (7.7, -0.8), 3: (7.7, 1.0), 4: (7.7, 8.65), 5: (14.0, 8.65),
              6: (5.0, 1.6), 7: (2.6, 2.2), 8: (15.2, 0.9), 9: (17.5, 0.6), 10: (17.6, 2.6),
              11: (21.6, 0.7), 12: (23.9, -2.6), 13: (14.4, -0.75)}
    ends = [(1, 2), (2, 3), (3, 4), (4, 5), (3, 6), (6, 7), (3, 8), (8, 9), (8, 10), (9, 10),
            (9, 11), (11, 12), (2, 13), (13, 9), (8, 13)]
    return Graph([Vertex(id, x, y, 0.0) for id, (x, y) in places.items()],
                 [Edge(id, *pair) for id, pair in enumerate(ends, 1)])
