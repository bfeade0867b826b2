"""Decides whether the robot's own path to a goal follows the edges of a route.

The LD-90 plans its own path to a goal, and fences keep it in the corridors of the graph. Therefore
the module assumes that the path is a shortest path over the curves of the edges, and cuts every
corner as far as the corridors allow. It relies on a path only if every other path is longer by more
than a corridor's width. The assumption is wrong if there are no fences, or if there are gaps
between corridors that are not in the graph.
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
    """Returns whether the robot's path from `arc` m on `edges[0]` follows all edges to the end of
    the last one.

    The caller knows already that the path follows all edges before the last one. The path must come
    within `tolerance` (m) of the vertex before the last edge.
    """
    slack = max(corridor_width / 2.0 - HALF_WIDTH, 0.0) + PLANNING_ERROR
    return (len(edges) == 1 or corner_cut(graph, edges[-2], edges[-1], slack) <= tolerance
            ) and not has_detour(graph, edges, arc, corridor_width)


# The results of `corner_cut` for each graph, kept while that graph is in use.
_cuts: MutableMapping[Graph, Dict[Tuple[int, int, float], float]] = WeakKeyDictionary()


def corner_cut(graph: Graph, first: int, second: int, slack: float) -> float:
    """Returns how far (m) the shortest path from edge `first` to edge `second` stays away from the
    vertex between them.

    The robot's centre may be `slack` m off the curves. The path stays away farthest if it passes
    the inner corner: the point farthest from the vertex that is within `slack` of both curves. At a
    right angle, its distance is 1.4 times the slack. At a cusp it is very large, because the robot
    need not drive to the vertex at all.
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
    """Returns whether another path to the end of `edges[-1]` bypasses some edges and is about as
    short.

    The robot is `arc` m along `edges[0]`. A path is about as short if it is at most `margin` (m)
    longer than the part that it bypasses. A path that joins the edges again before the last vertex
    counts as a detour, too.
    """
    lengths = accumulate((graph.curve(edge).length for edge in edges), initial=0.0)
    vertices = [graph.start_vertex(edges[0]).id] + [graph.end_vertex(edge).id for edge in edges]
    if vertices[-1] in vertices[:-1]:
        return True  # the edges return to a vertex, which no shortest path does
    ahead = {vertex: length - arc for vertex, length in zip(vertices, lengths)}
    end = ahead.pop(vertices[-1])
    around = distances(graph, vertices[-1], end + margin, {abs(edge) for edge in edges})
    # The first vertex is behind the robot, so its position is negative. A detour that begins there
    # includes the drive back to it: abs() makes this distance count.
    return any(around.get(vertex, math.inf) + abs(position) <= end + margin
               for vertex, position in ahead.items())
