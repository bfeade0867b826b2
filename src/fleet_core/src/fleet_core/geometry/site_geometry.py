"""The places of one graph, their curves, and the places that exclude each other.

They depend neither on closed edges nor on times. So one `SiteGeometry` serves a graph as long as
the graph is in force.
"""
from __future__ import annotations

from functools import cached_property
from itertools import takewhile
from typing import Dict, FrozenSet, List, NamedTuple, Sequence, Tuple

import numpy as np

from fleet_core.fleet import DOCK_APPROACH
from fleet_core.geometry.exclusions import Approach, Exclusions
from fleet_core.geometry.pieces import edge_lengths, pieces_of, splines_of
from trajectory_graph import Graph
from trajectory_graph.shortest_paths import Road, nearest_first


class Alone(NamedTuple):
    """Ids of edges and vertices. Only one robot at a time may be on any of them, even if they are
    far apart.

    The edges at these vertices belong to the group, too.
    """

    edges: FrozenSet[int]
    vertices: FrozenSet[int] = frozenset()


class SiteGeometry:
    """The numbered places of a graph: first the vertices, then the edges, in the graph's order.

    graph         -- the trajectory graph
    dock_approach -- m in front of a dock that belong to a robot while it docks or leaves
    alone         -- groups of places that exclude each other wherever they are
    """

    def __init__(self, graph: Graph, dock_approach: float = DOCK_APPROACH,
                 alone: Sequence[Alone] = ()) -> None:
        self.graph = graph
        self.dock_approach = dock_approach
        self.vertex_ids: Tuple[int, ...] = tuple(graph.vertices)
        self.edge_ids: Tuple[int, ...] = tuple(graph.edges)
        self.index: Dict[int, int] = {id: k for k, id in enumerate(self.vertex_ids)}
        """The number of each vertex, by its id. The place of the vertex has the same number."""
        self.edge_index: Dict[int, int] = {id: k for k, id in enumerate(self.edge_ids)}
        self.ends = np.array([(self.index[edge.origin], self.index[edge.destination])
                              for edge in graph.edges.values()], dtype=np.int64).reshape(-1, 2)
        """(E, 2) vertices at the origin and the destination of each edge."""
        self.alone = tuple(alone)
        self._splines = splines_of(graph)
        self.lengths = edge_lengths(graph, self._splines)
        """(E,) arc lengths in m."""

    def edge_place(self, signed_id: int) -> int:
        """Returns the place of an edge, in both directions."""
        return len(self.vertex_ids) + self.edge_index[abs(signed_id)]

    @cached_property
    def exclusions(self) -> Exclusions:
        """The places that exclude each other, for each requested distance."""
        return Exclusions(pieces_of(self.graph, self._splines), self.ends, len(self.vertex_ids),
                          self._approaches(), tuple(map(self._places_of, self.alone)))

    def _places_of(self, alone: Alone) -> Tuple[int, ...]:
        edges = {edge.id for edge in self.graph.edges.values() if edge.id in alone.edges
                 or not alone.vertices.isdisjoint((edge.origin, edge.destination))}
        return (*(self.index[vertex] for vertex in sorted(alone.vertices & self.index.keys())),
                *map(self.edge_place, sorted(edges)))

    def _approaches(self) -> Tuple[Approach, ...]:
        """Returns all places within `dock_approach` of each dock along the edges."""
        docks = [vertex.id for vertex in self.graph.vertices.values() if vertex.dock]
        if not docks:
            return ()
        roads: List[List[Road]] = [[] for _ in self.vertex_ids]
        for edge, (origin, destination), length in zip(
                self.edge_ids, self.ends.tolist(), map(float, self.lengths)):
            roads[origin].append(Road(destination, length, edge))
            roads[destination].append(Road(origin, length, -edge))
        return tuple(self._approach(self.index[dock], roads)
                     for dock in sorted(docks, key=self.index.__getitem__))

    def _approach(self, dock: int, roads: List[List[Road]]) -> Approach:
        near = self._near(dock, roads)
        reach = self.dock_approach
        edges: Dict[int, Tuple[float, float]] = {}
        for edge, (ends, length) in enumerate(zip(self.ends.tolist(), map(float, self.lengths))):
            from_origin, from_destination = (
                min(max((reach - near.get(end, reach)) / length, 0.0), 1.0) for end in ends)
            place = len(self.vertex_ids) + edge
            if from_origin + from_destination >= 1.0 or (from_origin and from_destination):
                edges[place] = (0.0, 1.0)
            elif from_origin:
                edges[place] = (0.0, from_origin)
            elif from_destination:
                edges[place] = (1.0 - from_destination, 1.0)
        return Approach(edges, frozenset(near) - {dock})

    def _near(self, dock: int, roads: List[List[Road]]) -> Dict[int, float]:
        """Returns all vertices that are nearer to a dock than `dock_approach`, each with its
        distance (m) from the dock along the edges.
        """
        near = takewhile(lambda reached: reached.distance < self.dock_approach,
                         nearest_first(dock, roads.__getitem__))
        return {reached.vertex: reached.distance for reached in near}
