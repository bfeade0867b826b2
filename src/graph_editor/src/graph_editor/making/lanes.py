"""Straight lanes between nodes: the intermediate form between skeleton and trajectory graph."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Dict, Iterator, List, Set, Tuple, Union

import networkx as nx
import numpy as np

from graph_editor.floor import Floor
from graph_editor.making.sight import in_sight, straight


@dataclass(frozen=True, eq=False)
class Lane:
    """A straight lane between two nodes; the node with the lower id is the first one."""

    nodes: Tuple[int, int]
    need: float
    """The clearance (m) that the lane must keep when it is moved."""
    samples: np.ndarray
    """The points (N,2; m) of the skeleton that the lane represents, beginning at the first node."""


LaneOrNode = Union[Lane, int]
"""The lane or node at which another lane may join."""


class LaneNet:
    """Nodes with positions (m) and the lanes between them; two nodes have at most one lane.

    All steps that make a graph use this class. It has one method for each query and for each edit.
    """

    def __init__(self, floor: Floor) -> None:
        self.floor = floor
        self.positions: Dict[int, np.ndarray] = {}
        self._graph = nx.Graph()
        self._next_node = 1

    @property
    def lanes(self) -> List[Lane]:
        """All lanes, in the sequence in which they were added."""
        return [lane for _, _, lane in self._graph.edges(data='lane')]

    @property
    def nodes(self) -> List[int]:
        """All nodes, in the sequence in which they were added."""
        return list(self._graph.nodes)

    def copy(self) -> LaneNet:
        """Returns an independent copy of the net."""
        other = LaneNet(self.floor)
        other.positions = dict(self.positions)
        other._graph = self._graph.copy()
        other._next_node = self._next_node
        return other

    def add_node(self, position: np.ndarray) -> int:
        """Adds a node and returns its id."""
        node = self._next_node
        self._next_node += 1
        self._graph.add_node(node)
        self.positions[node] = np.asarray(position, float)
        return node

    def add_lane(self, a: int, b: int, need: float, samples: np.ndarray) -> None:
        """Adds a lane from `a` to `b`. An old lane between them is replaced if its `need` is
        smaller.
        """
        if a == b:
            return
        old = self.lane(a, b) if self._graph.has_edge(a, b) else None
        if old is not None and old.need >= need:
            return
        if a > b:
            a, b, samples = b, a, samples[::-1]
        self._graph.add_edge(a, b, lane=Lane((a, b), need, samples))

    def lane(self, a: int, b: int) -> Lane:
        """Returns the lane between two nodes."""
        return self._graph.edges[a, b]['lane']

    def neighbours(self, node: int) -> List[int]:
        """Returns the nodes to which lanes lead from a node."""
        return list(self._graph.neighbors(node))

    def degree(self, node: int) -> int:
        """Returns the number of lanes at a node."""
        return self._graph.degree(node)

    def remove_lane(self, lane: Lane) -> None:
        """Removes a lane; its nodes stay."""
        self._graph.remove_edge(*lane.nodes)

    def remove_node(self, node: int) -> None:
        """Removes a node and its lanes."""
        self._graph.remove_node(node)
        del self.positions[node]

    def ends(self, lane: Lane) -> Tuple[np.ndarray, np.ndarray]:
        """Returns the positions of a lane's nodes."""
        a, b = lane.nodes
        return self.positions[a], self.positions[b]

    def length(self, lane: Lane) -> float:
        """Returns the length of a lane, m."""
        a, b = self.ends(lane)
        return float(np.hypot(*(b - a)))

    def clearance(self, lane: Lane) -> float:
        """Returns the smallest clearance along the lane, m."""
        return float(self.floor.clearance_at(straight(self.floor, *self.ends(lane))).min())

    def is_free(self, lane: Lane) -> bool:
        """Returns whether the lane has the clearance that it needs."""
        return in_sight(self.floor, *self.ends(lane), lane.need)

    def split(self, lane: Lane, position: np.ndarray) -> int:
        """Splits a lane in two at a new node at `position`; returns the node."""
        a, b = lane.nodes
        node = self.add_node(position)
        self.remove_lane(lane)
        nearest = int(np.argmin(((lane.samples - position) ** 2).sum(axis=1)))
        self.add_lane(a, node, lane.need, lane.samples[:nearest + 1])
        self.add_lane(node, b, lane.need, lane.samples[nearest:])
        return node

    def joint(self, where: LaneOrNode, position: np.ndarray) -> int:
        """Returns the node at which a lane joins: node `where`, or a new node on lane `where`."""
        return self.split(where, position) if isinstance(where, Lane) else where

    def merge(self, node: int, other: int) -> None:
        """Moves the lanes of `other` to `node`, and removes `other`."""
        for neighbour in self.neighbours(other):
            lane = self.lane(other, neighbour)
            self.remove_lane(lane)
            samples = lane.samples if lane.nodes[0] == other else lane.samples[::-1]
            self.add_lane(node, neighbour, lane.need, samples)
        self.remove_node(other)

    def components(self) -> Iterator[Set[int]]:
        """Yields the sets of connected nodes."""
        return nx.connected_components(self._graph)

    def with_need(self, lane: Lane, need: float) -> None:
        """Sets the clearance that a lane needs, m."""
        self._graph.edges[lane.nodes]['lane'] = replace(lane, need=need)
