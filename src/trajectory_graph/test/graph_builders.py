"""Small graphs for several tests."""
from __future__ import annotations

from typing import Dict, Tuple

from trajectory_graph import CurveType, Edge, Graph, Vertex


def graph_of(places: Dict[int, Tuple[float, float]], ends: Dict[int, Tuple[int, int]]) -> Graph:
    """Returns a graph of straight edges.

    places -- vertices: {id: (x, y)}
    ends   -- edges: {id: (origin, destination)}
    """
    return Graph([Vertex(id, x, y, 0.0) for id, (x, y) in places.items()],
                 [Edge(id, *pair) for id, pair in ends.items()])


def dissertation_graph() -> Graph:
    """Returns the dissertation's example.

    Its route [E1, E4, E5] leads from V1 over V2 and V7 to V6.
    """
    return graph_of({1: (0, 0), 2: (2, 0), 7: (4, 0), 6: (4, 2), 3: (2, 2)},
                    {1: (1, 2), 4: (2, 7), 5: (7, 6), 2: (2, 3)})


def spline_graph() -> Graph:
    """Returns a graph of edge 1, a spline from (0, 0) heading east to (2, 2) heading north."""
    return Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 2.0, 2.0, 1.5707963267948966)],
                 [Edge(1, 1, 2, CurveType.SPLINE, 1.0, 1.0)])
