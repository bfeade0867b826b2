"""Parking: vertices at which robots may stand for ever without cutting off any robot.

A set of parking vertices is *well-formed* if two conditions hold while a robot stands on each of
them (Cap et al., arXiv 1501.07704):

- The rest of the graph is still connected.
- Each of these robots can leave its vertex and come back.

Then robots can always move, in all missions. A vertex that the graph forbids as parking, such as
one between two sections of an edge, may be cut off. If closed edges divide the graph into parts
without a path between them, the conditions hold for each part.

The capacity of the graph is the size of the largest such set. The largest set is hard to find. So
the search begins at many sets, and ends after a fixed amount of work. The result is certain to be
well-formed, and on small graphs it is rarely too small. The result depends on the graph alone, not
on the speed of the computer.
"""
from __future__ import annotations

from math import inf
from random import Random
from typing import FrozenSet, Iterable, List, Optional, Sequence, Set, Tuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from fleet_core.fleet import RobotType
from fleet_core.geometry.arrays import count_up
from fleet_core.planning.road_network import RoadNetwork

_TRIALS = 20
# The search ends after so many consecutive trials without gain. Two would have been enough for each
# of 40 random graphs.
_FRUITLESS = 4
# All checks of one search together may examine at most so many places. The search on a graph of 25
# vertices needs a twentieth of this number. A larger number gained nothing on graphs of 64 and of
# 100 vertices.
_WORK = 3_000_000


class WellFormedSets:
    """Well-formed sets of one robot type on one graph.

    candidates -- vertices that may be used; empty: the vertices that the graph names as parking,
                  or, if it names none, all except docks and forbidden ones
    """

    def __init__(self, network: RoadNetwork, kind: RobotType, clearance: float,
                 candidates: Iterable[int] = ()) -> None:
        self._network = network
        self._candidates = sorted(candidates) or named_parking(network, kind)
        self._vertices = network.vertices
        self._wanted = np.array([network.graph.vertices[id].parking is not False
                                 for id in network.vertex_ids])
        self._conflicts = network.exclusions.at(2.0 * kind.reach + clearance)
        times = np.array(network.times(kind))
        usable = [drive for drive in range(network.drives) if np.isfinite(times[drive])
                  and network.edge_ids[drive >> 1] not in network.closed]
        self._begin = np.array([network.origin[d] for d in usable], dtype=np.int64)
        self._end = np.array([network.origin[d ^ 1] for d in usable], dtype=np.int64)
        self._edge = np.array([self._vertices + (d >> 1) for d in usable], dtype=np.int64)
        self._part = self._parts(self._begin, self._end, self._vertices)
        """The part of the graph of each vertex. Closed edges may divide it into several parts."""
        self._checks = 0  # number of checks that the search may still make

    def is_well_formed(self, parked: Iterable[int]) -> bool:
        """Returns whether no robot is cut off while robots stand on all these vertices."""
        vertices = np.array(sorted(parked), dtype=np.int64)
        starts = self._conflicts.starts
        lengths = starts[vertices + 1] - starts[vertices]
        taken = self._conflicts.other[np.repeat(starts[vertices], lengths) + count_up(lengths)]
        places = self._vertices + len(self._network.edge_ids)
        count = np.bincount(taken, minlength=places)
        owner = np.full(places, -1, dtype=np.int64)
        owner[taken] = np.repeat(vertices, lengths)
        if (count[vertices] != 1).any():
            return False  # two of the vertices exclude each other
        core = self._core(count)
        if core is None:
            return False
        # To the core and back, each robot may use only places that no other parked robot blocks.
        # The nodes are all vertices, followed by one node for each robot: the core, as the robot
        # may use it.
        own = count[self._edge] == 1
        begin, end, whose = self._begin[own], self._end[own], owner[self._edge[own]]
        fits = np.ones(len(begin), dtype=bool)
        sides = []
        for side in (begin, end):
            fits &= core[side] | ((count[side] == 1) & (owner[side] == whose))
            sides.append(np.where(core[side], self._vertices + whose, side))
        part = self._parts(sides[0][fits], sides[1][fits], 2 * self._vertices)
        around = np.bincount(self._part[core], minlength=self._vertices)[self._part[vertices]]
        robots = np.bincount(self._part[vertices], minlength=self._vertices)[self._part[vertices]]
        alone = (around == 0) & (robots == 1)
        return bool((alone | (part[vertices] == part[self._vertices + vertices])).all())

    def _core(self, count: np.ndarray) -> Optional[np.ndarray]:
        """Returns the vertices (V,) between which all robots can drive, in each part of the graph.

        count -- number of robots that block each place

        Returns None if one of the vertices that robots may have to visit is not among them.
        """
        free = count[:self._vertices] == 0
        usable = count[self._edge] == 0
        left = self._parts(self._begin[usable], self._end[usable], self._vertices)
        sizes = np.bincount(left[free], minlength=self._vertices)
        # The core of each part of the graph is the largest of its remaining pieces, preferably one
        # with wanted vertices.
        vertices = np.flatnonzero(free)
        order = vertices[np.lexsort((sizes[left[vertices]], self._wanted[vertices]))]
        core = np.full(self._vertices, -1, dtype=np.int64)
        core[self._part[order]] = left[order]  # numpy keeps the last value of each part
        inside = free & (left == core[self._part])
        return inside if inside[free & self._wanted].all() else None

    @staticmethod
    def _parts(begin: np.ndarray, end: np.ndarray, nodes: int) -> np.ndarray:
        """Returns for each node the strongly connected part to which it belongs."""
        links = csr_matrix((np.ones(len(begin)), (begin, end)), shape=(nodes, nodes))
        return connected_components(links, directed=True, connection='strong')[1]

    def largest(self, seed: int = 0, enough: float = inf) -> FrozenSet[int]:
        """Returns the largest well-formed set that was found, or the first set with `enough`
        vertices.
        """
        random = Random(seed)
        best: Set[int] = set()
        fruitless = 0
        self._checks = _WORK // (self._vertices + len(self._network.edge_ids))
        for trial in range(_TRIALS):
            order = self._by_promise()
            if trial:
                random.shuffle(order)
            found = self._grown(set(), order)
            if len(found) < enough:
                found = self._exchanged(found, order)
            fruitless += 1
            if len(found) > len(best):
                best, fruitless = found, 0
            if fruitless == _FRUITLESS or len(best) >= enough or self._checks <= 0:
                break
        return frozenset(best)

    def _by_promise(self) -> List[int]:
        """Returns the candidates: dead ends first, then vertices with few edges."""
        import networkx as nx  # imported here: most nodes need not load its 8 MB
        roads = nx.Graph(zip(map(int, self._begin), map(int, self._end)))
        roads.add_nodes_from(range(self._vertices))
        cut = set(nx.articulation_points(roads))
        return sorted(self._candidates, key=lambda v: (v in cut, roads.degree(v), v))

    def _grown(self, parked: Set[int], order: Sequence[int]) -> Set[int]:
        """Adds the vertices that can be added, in this order. A batch that fails is halved."""
        waiting: List[Tuple[int, ...]] = [tuple(v for v in order if v not in parked)]
        parked = set(parked)
        while waiting:
            batch = waiting.pop()
            if not batch:
                continue
            self._checks -= 1
            if self.is_well_formed(parked.union(batch)):
                parked.update(batch)
            elif len(batch) > 1:
                half = (len(batch) + 1) // 2
                waiting += [batch[half:], batch[:half]]
        return parked

    def _exchanged(self, parked: Set[int], order: Sequence[int]) -> Set[int]:
        """Replaces one vertex by two others, again and again, until the checks are used up."""
        better = True
        while better:
            better = False
            for vertex in sorted(parked):
                if self._checks <= 0:
                    break
                found = self._grown(parked - {vertex}, [v for v in order if v != vertex])
                if len(found) > len(parked):
                    parked, better = found, True
                    break
        return parked


def named_parking(network: RoadNetwork, kind: RobotType) -> List[int]:
    """Returns the vertices at which the graph allows robots of a type to park."""
    vertices = [network.graph.vertices[id] for id in network.vertex_ids]
    docks = kind.docks or frozenset()
    named = any(v.parking for v in vertices)
    return [network.index[v.id] for v in vertices
            if (v.id in docks if v.dock else v.parking if named else v.parking is not False)]
