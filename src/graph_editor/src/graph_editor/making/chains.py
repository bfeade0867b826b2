"""The skeleton during its processing: nodes, and chains of points between the nodes.

Both ends of a chain may be the same node. If exactly two chains meet at a node, they are joined to
one chain.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Iterator, List, Optional, Sequence, Tuple

import networkx as nx
import numpy as np

from graph_editor.floor import Floor


@dataclass(frozen=True, eq=False)
class Chain:
    """A path from node `start` to node `end`; lengths in m."""

    id: int
    start: int
    end: int
    path: np.ndarray
    """The points (N,2; m), including the positions of both nodes."""
    length: float
    clearances: np.ndarray
    """The clearances (N,; m) at the points of the path."""

    @property
    def is_ring(self) -> bool:
        """Whether the chain ends at its start node."""
        return self.start == self.end

    @property
    def clearance(self) -> float:
        """The smallest clearance along the chain, m."""
        return float(self.clearances.min())

    def other(self, node: int) -> int:
        """Returns the node at the other end."""
        return self.end if node == self.start else self.start

    def path_from(self, node: int) -> np.ndarray:
        """Returns the path, starting at the given end node."""
        return self.path if node == self.start else self.path[::-1]

    def clearances_towards(self, node: int) -> np.ndarray:
        """Returns the clearances (m) along the path that ends at the given end node."""
        return self.clearances if node == self.end else self.clearances[::-1]


class ChainGraph:
    """Nodes with positions (m), and the chains between them.

    All steps that make a graph use this class. It has one method for each query and for each edit.
    """

    def __init__(self, floor: Floor) -> None:
        self.floor = floor
        self._graph = nx.MultiGraph()
        self._chains: Dict[int, Chain] = {}
        self._next_id = 1

    @property
    def nodes(self) -> List[int]:
        """All nodes, in the sequence in which they were added."""
        return list(self._graph.nodes)

    @property
    def chains(self) -> List[Chain]:
        """All chains, in the sequence in which they were added."""
        return list(self._chains.values())

    def position(self, node: int) -> np.ndarray:
        """Returns the position (2,) of a node, m."""
        return self._graph.nodes[node]['position']

    def degree(self, node: int) -> int:
        """Returns the number of chains that end at a node; a ring counts twice."""
        return self._graph.degree(node)

    def chains_at(self, node: int) -> List[Chain]:
        """Returns the chains that end at a node; a ring is listed once."""
        ids = {id for _, _, id in self._graph.edges(node, keys=True)}
        return [self._chains[id] for id in sorted(ids)]

    def has(self, chain: Chain) -> bool:
        """Returns whether the chain is still in the graph."""
        return chain.id in self._chains

    def add_node(self, node: int, position: np.ndarray) -> None:
        """Adds a node without chains."""
        self._graph.add_node(node, position=np.asarray(position, float))

    def add_chain(self, start: int, end: int, path: np.ndarray) -> Chain:
        """Adds a chain along `path` (N,2), from the position of `start` to that of `end`."""
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        chain = Chain(self._next_id, start, end, path, float(steps.sum()),
                      self.floor.clearance_at(path))
        self._next_id += 1
        self._chains[chain.id] = chain
        self._graph.add_edge(start, end, key=chain.id, length=chain.length)
        return chain

    def remove_chain(self, chain: Chain) -> List[Chain]:
        """Removes a chain and dissolves its end nodes if possible; returns the new chains."""
        return self.remove_all([chain])

    def remove_all(self, chains: Sequence[Chain]) -> List[Chain]:
        """Removes several chains like `remove_chain`. The last node of the graph is never removed.
        """
        for chain in chains:
            self.drop_chain(chain)
        made = []
        for node in dict.fromkeys(node for chain in chains for node in (chain.start, chain.end)):
            if self._graph.degree(node) == 0 and len(self._graph) > 1:
                self._graph.remove_node(node)
            else:
                made += self.dissolve(node)
        return [new for new in made if self.has(new)]

    def cut_out(self, chain: Chain, first: int, last: int) -> List[Chain]:
        """Removes the part of a chain between two of its points, including these points.

        The remaining part at each end becomes a dead end. Returns the new chains.
        """
        self.drop_chain(chain)
        made, bare = [], []
        for node, path in ((chain.start, chain.path[:first]),
                           (chain.end, chain.path[:last:-1])):
            if len(path) > 1:
                tip = max(self._graph.nodes) + 1
                self.add_node(tip, path[-1])
                made.append(self.add_chain(node, tip, path))
            else:
                bare.append(node)
        for node in dict.fromkeys(bare):  # both ends of a ring are the same node
            made += self.dissolve(node)
        return [chain for chain in made if self.has(chain)]

    def dissolve(self, node: int) -> List[Chain]:
        """Joins two chains that meet at a node without a third chain; returns the new chain."""
        chains = self.chains_at(node)
        if self._graph.degree(node) != 2 or len(chains) != 2:
            return []
        first, second = chains
        path = np.vstack((first.path_from(first.other(node)), second.path_from(node)[1:]))
        self.drop_chain(first)
        self.drop_chain(second)
        self._graph.remove_node(node)
        return [self.add_chain(first.other(node), second.other(node), path)]

    def move_node(self, node: int, path: np.ndarray) -> None:
        """Moves a node along `path` (N,2), which begins at the node, and extends the node's chains.
        """
        self._graph.nodes[node]['position'] = path[-1]
        for chain in self.chains_at(node):
            old = chain.path
            if chain.start == node:
                old = np.vstack((path[::-1], old[1:]))
            if chain.end == node:
                old = np.vstack((old[:-1], path))
            self.drop_chain(chain)
            self.add_chain(chain.start, chain.end, old)

    def unite(self, node: int, other: int) -> None:
        """Moves the chains of `other` to `node`, which has the same position, and removes `other`.
        """
        for chain in self.chains_at(other):
            self.drop_chain(chain)
            start, end = (node if place == other else place for place in (chain.start, chain.end))
            self.add_chain(start, end, chain.path)
        self._graph.remove_node(other)

    def way_round(self, chain: Chain) -> Optional[float]:
        """Returns the length (m) of the shortest path from one end of a chain to the other that
        does not use this chain.

        None: there is no such path; 0: the chain is a ring.
        """
        if chain.is_ring:
            return 0.0
        self._graph.remove_edge(chain.start, chain.end, key=chain.id)
        try:
            return float(nx.dijkstra_path_length(self._graph, chain.start, chain.end,
                                                 weight='length'))
        except nx.NetworkXNoPath:
            return None
        finally:
            self._graph.add_edge(chain.start, chain.end, key=chain.id, length=chain.length)

    def dead_ends(self) -> Iterator[Tuple[int, Chain]]:
        """Yields the dead ends at junctions: the end node, and the chain from it to the
        junction.
        """
        for node in self.nodes:
            if self._graph.degree(node) == 1:
                chain, = self.chains_at(node)
                if self._graph.degree(chain.other(node)) > 2:
                    yield node, chain

    def drop_chain(self, chain: Chain) -> None:
        """Removes a chain; its nodes do not change."""
        del self._chains[chain.id]
        self._graph.remove_edge(chain.start, chain.end, key=chain.id)
