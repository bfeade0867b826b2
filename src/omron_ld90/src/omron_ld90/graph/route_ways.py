"""Would the robot, left to itself, drive the edges of a route?

The LD-90 plans its own free way to a goal. Fences keep it in the corridors of the graph, so its
way is taken to be a shortest way over the graph, with lengths of the edges' curves. Corners are cut
and curves taken on the inside, so lengths that differ by less than `margin` count as equal, and a
way is only relied upon when every other one is longer than that. Without fences, or with gates
between corridors that the graph does not know, the assumption does not hold.
"""
from __future__ import annotations

import heapq
from itertools import accumulate
from typing import AbstractSet, Dict, Sequence

from trajectory_graph import Graph


def is_the_free_way(graph: Graph, edges: Sequence[int], arc: float, margin: float) -> bool:
    """Does the free way from `arc` m along `edges[0]` to the end of `edges[-1]` follow them all?

    True when no detour around any part of the route is as short as that part plus `margin` (m).
    Every other way to the same end turns off the route somewhere and joins it again farther on, so
    it is enough to look at the detours from the robot backwards and from each vertex of the route.
    """
    start = graph.start_vertex(edges[0]).id
    vertices = [graph.end_vertex(edge).id for edge in edges]
    if len({start, *vertices}) <= len(edges):
        return False  # it comes back to a vertex, which no shortest way does
    lengths = accumulate(graph.curve(edge).length for edge in edges)
    ahead = {vertex: length - arc for vertex, length in zip(vertices, lengths)}
    total = ahead[vertices[-1]]
    own = {abs(edge) for edge in edges}

    def can_be_bypassed(source: int, position: float, cost: float) -> bool:
        """A later vertex is as near as by the route, going by `source`, `cost` m from `position`.

        `position` is measured along the route from the robot.
        """
        reach = distances(graph, source, total - position - cost + margin, own)
        return any(ahead.get(vertex, 0.0) > position
                   and cost + distance <= ahead[vertex] - position + margin
                   for vertex, distance in reach.items())

    return not (can_be_bypassed(start, 0.0, arc)
                or any(can_be_bypassed(vertex, ahead[vertex], 0.0) for vertex in vertices[:-1]))


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
        for id in graph.edges_at(vertex):
            if id not in without:
                edge = graph.edge(id)
                other = edge.destination if edge.origin == vertex else edge.origin
                heapq.heappush(queue, (distance + graph.curve(id).length, other))
    return found
