"""Routes: signed edge ids in driving order."""
from __future__ import annotations

from typing import List, Sequence

from trajectory_graph.drawn_names import edge_name
from trajectory_graph.errors import DiscontinuousRoute, ForbiddenDirection
from trajectory_graph.graph import Graph
from trajectory_graph.graph_changes import speed_of


def check_route(graph: Graph, edges: Sequence[int]) -> None:
    """Raises UnknownEdge, or DiscontinuousRoute if an edge does not continue the previous one."""
    for edge in edges:
        graph.edge(edge)
    for first, second in zip(edges, edges[1:]):
        end, start = graph.end_vertex(first).id, graph.start_vertex(second).id
        if end != start:
            raise DiscontinuousRoute(first, end, second, start)


def check_drivable(graph: Graph, edges: Sequence[int]) -> None:
    """Raises the errors of `check_route`, or ForbiddenDirection if an edge has the speed 0 in the
    direction of the route.
    """
    check_route(graph, edges)
    for edge in edges:
        if speed_of(graph, edge) <= 0.0:
            raise ForbiddenDirection(edge, edge_name(graph, edge))


def route_vertices(graph: Graph, edges: Sequence[int]) -> List[int]:
    """Returns the ids of the vertices to visit, in order, without the start vertex.

    Example: the edges [E1, E4, E5] from V1 have the ends [V1, V2, V2, V7, V7, V6]. The vertices to
    visit are [V2, V7, V6].
    Raises the errors of `check_route`.
    """
    check_route(graph, edges)
    return [graph.end_vertex(edge).id for edge in edges]
