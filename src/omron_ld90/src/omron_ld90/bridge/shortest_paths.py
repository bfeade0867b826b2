"""Decides whether the robot's own path to a goal follows the edges of a route.

The LD-90 plans its own path to a goal. Fences keep it in the corridors of the graph. Its path is
therefore assumed to be a shortest path over the graph, with the lengths of the edges' curves, that
cuts every corner as far as the corridors allow. Lengths that differ by less than a corridor's width
count as equal. A path is relied upon only if every other path is longer by more than that. Without
fences, or with gates between corridors that the graph does not have, the assumption is wrong.
"""
from __future__ import annotations

import math
from itertools import accumulate
from typing import Dict, MutableMapping, Sequence, Tuple
from weakref import WeakKeyDictionary

from omron_map_converter.footprint import HALF_WIDTH
from trajectory_graph import Graph
from trajectory_graph.shortest_paths import distances

PLANNING_ERROR = 0.05    # m, error of the robot's own planner and its localization
STEP = 0.02              # m between the examined points along a curve
FARTHEST_CUT = 3.0       # m before a vertex at which the robot may begin to cut the corner


def follows_on(graph: Graph, edges: Sequence[int], arc: float, corridor_width: float,
               tolerance: float) -> bool:
    """Returns whether the robot's path from `arc` m on `edges[0]` also follows the last edge to its
    end.

    Its path along the edges before that is known. It must come within `tolerance` (m) of the vertex
    before the last edge.
    """
    slack = max(corridor_width / 2.0 - HALF_WIDTH, 0.0) + PLANNING_ERROR
    return (len(edges) == 1 or corner_cut(graph, edges[-2], edges[-1], slack) <= tolerance
            ) and not has_detour(graph, edges, arc, corridor_width)


# The results of `corner_cut` for each graph, kept while that graph is in use.
_cuts: MutableMapping[Graph, Dict[Tuple[int, int, float], float]] = WeakKeyDictionary()


def corner_cut(graph: Graph, first: int, second: int, slack: float) -> float:
    """Returns the distance (m) of the shortest path from edge `first` to edge `second` from their
    vertex.

    The robot's centre may be `slack` m off the curves. The inner corner of its path is the point
    farthest from the vertex that is within `slack` of both curves. At a right angle this is 1.4
    times the slack; at a cusp, where the robot need not drive to the vertex at all, it is very far.
    """
    known = _cuts.setdefault(graph, {})
    corner = (first, second, slack)
    if corner not in known:
        known[corner] = _corner_cut(graph, *corner)
    return known[corner]


def _corner_cut(graph: Graph, first: int, second: int, slack: float) -> float:
    before, after = graph.curve(first), graph.curve(second)
    vertex = graph.end_vertex(first)
    farthest = 0.0
    back = 0.0
    while back <= min(before.length, FARTHEST_CUT):
        s = before.length - back
        x, y = before.point_at(s)
        heading = before.heading_at(s)
        for side in (-slack, slack):
            edge_of_strip = (x - side * math.sin(heading), y + side * math.cos(heading))
            if after.project(*edge_of_strip).distance <= slack:
                farthest = max(farthest, math.dist(edge_of_strip, vertex.position))
        back += STEP
    return farthest


def has_detour(graph: Graph, edges: Sequence[int], arc: float, margin: float) -> bool:
    """Returns whether another path to the end of `edges[-1]` bypasses some edges and is equally
    short.

    The robot is `arc` m along `edges[0]`. A path is equally short if it is not longer than the
    bypassed part by more than `margin` (m). A path that leaves the edges joins them again
    somewhere. So a path that joins them before the last vertex is also a detour to that vertex.
    """
    lengths = accumulate((graph.curve(edge).length for edge in edges), initial=0.0)
    vertices = [graph.start_vertex(edges[0]).id] + [graph.end_vertex(edge).id for edge in edges]
    if vertices[-1] in vertices[:-1]:
        return True  # the edges return to a vertex, which no shortest path does
    ahead = {vertex: length - arc for vertex, length in zip(vertices, lengths)}
    end = ahead.pop(vertices[-1])
    around = distances(graph, vertices[-1], end + margin, {abs(edge) for edge in edges})
    # To turn off at the first vertex, which is behind it, the robot must drive back: hence abs.
    return any(around.get(vertex, math.inf) + abs(position) <= end + margin
               for vertex, position in ahead.items())
