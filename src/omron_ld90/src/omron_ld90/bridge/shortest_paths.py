"""Would the robot, left to itself, drive the edges of a route?

The LD-90 plans its own free way to a goal. Fences keep it in the corridors of the graph, so its
way is taken to be a shortest way over the graph, with lengths of the edges' curves, that cuts
every corner as far as the corridors allow. Lengths that differ by less than a corridor's width
count as equal, and a way is only relied upon when every other one is longer than that. Without
fences, or with gates between corridors that the graph does not know, this does not hold.
"""
from __future__ import annotations

import heapq
import math
from itertools import accumulate
from typing import AbstractSet, Dict, MutableMapping, Sequence, Tuple
from weakref import WeakKeyDictionary

from omron_ld90.robot_model import HALF_WIDTH
from trajectory_graph import Graph

PLANNING_ERROR = 0.05    # m that the robot's own planner and its localization may be off
STEP = 0.02              # m between points looked at along a curve
FARTHEST_CUT = 3.0       # m before a vertex from which a corner can be cut


def follows_on(graph: Graph, edges: Sequence[int], arc: float, corridor_width: float,
               tolerance: float) -> bool:
    """Does the free way from `arc` m along `edges[0]` lead along the last edge to its end, too?

    It is known to lead along the edges before that. It has to come within `tolerance` (m) of the
    vertex between.
    """
    slack = max(corridor_width / 2.0 - HALF_WIDTH, 0.0) + PLANNING_ERROR
    return (len(edges) == 1 or corner_cut(graph, edges[-2], edges[-1], slack) <= tolerance
            ) and not has_detour(graph, edges, arc, corridor_width)


# What `corner_cut` found for a graph, as long as that graph is in use.
_cuts: MutableMapping[Graph, Dict[Tuple[int, int, float], float]] = WeakKeyDictionary()


def corner_cut(graph: Graph, first: int, second: int, slack: float) -> float:
    """How far (m) from the vertex between two edges the shortest way from one to the other passes.

    The robot's centre may be `slack` m off the curves. The inner corner that it goes round is the
    point farthest from the vertex among those that are so near to both curves: at a right angle
    1.4 times the slack, at a cusp, where the robot need not go to the vertex at all, very far.
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
    """Does another way to the end of `edges[-1]` bypass some of them, and is as short?

    The robot is `arc` m along `edges[0]`. As short is what is not longer than the part bypassed by
    more than `margin` (m). A way that turns off the edges joins them again somewhere, so that one
    which joins them before the last vertex is a detour to that vertex.
    """
    lengths = accumulate((graph.curve(edge).length for edge in edges), initial=0.0)
    vertices = [graph.start_vertex(edges[0]).id] + [graph.end_vertex(edge).id for edge in edges]
    if vertices[-1] in vertices[:-1]:
        return True  # the edges come back to a vertex, which no shortest way does
    ahead = {vertex: length - arc for vertex, length in zip(vertices, lengths)}
    end = ahead.pop(vertices[-1])
    around = distances(graph, vertices[-1], end + margin, {abs(edge) for edge in edges})
    # To turn off at the first vertex, which is behind it, the robot has to drive back: abs.
    return any(around.get(vertex, math.inf) + abs(position) <= end + margin
               for vertex, position in ahead.items())


def distances(graph: Graph, source: int, limit: float,
              without: AbstractSet[int] = frozenset()) -> Dict[int, float]:
    """Length in m of the shortest way from `source` to every vertex not farther than `limit`.

    Edges can be driven both ways; those whose ids are in `without` not at all.
    """
    found: Dict[int, float] = {}
    queue = [(0.0, source)]
    while queue:
        distance, vertex = heapq.heappop(queue)
        if vertex in found or distance > limit:
            continue
        found[vertex] = distance
        for edge in graph.edges_from(vertex):
            if abs(edge) not in without:
                heapq.heappush(queue, (distance + graph.curve(abs(edge)).length,
                                       graph.end_vertex(edge).id))
    return found
