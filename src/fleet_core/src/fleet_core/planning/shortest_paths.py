"""Shortest driving times from all vertices to some targets, for graphs with many lanes and dead
ends.

Vertices with at most two neighbours are removed first, in rounds. Each removed vertex leaves a link
between its neighbours. So a lane that was cut into sections becomes one link, and a dead end
disappears. Dijkstra's algorithm runs on the remaining graph. Then the times from the removed
vertices are computed round by round (PHAST: Delling et al., IPDPS 2011).
"""
from __future__ import annotations

from heapq import heappop, heappush
from math import inf
from typing import Dict, Iterable, List, NamedTuple, Sequence, Tuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra


class _Round(NamedTuple):
    """N vertices that were removed together, none of them next to another."""

    vertices: np.ndarray    # (N,)
    neighbours: np.ndarray  # (2, N) not removed before; the vertex itself stands for none
    seconds: np.ndarray     # (2, N) of the roads from the vertex to these neighbours


class ShortestPaths:
    """The roads between numbered vertices, prepared for shortest paths to any of them.

    vertices -- number of vertices
    roads    -- (begin, end, seconds)
    """

    def __init__(self, vertices: int, roads: Iterable[Tuple[int, int, float]]) -> None:
        self._away: List[Dict[int, float]] = [{} for _ in range(vertices)]
        self._back: List[Dict[int, float]] = [{} for _ in range(vertices)]
        """For each vertex, the seconds to its neighbours (`_away`) and from them (`_back`).

        For a removed vertex: to and from the neighbours that had not been removed before it.
        """
        for begin, end, seconds in roads:
            if begin != end:
                self._join(begin, end, seconds)
        self._round: List[int] = [-1] * vertices
        self._rounds: List[_Round] = []
        self._take_out()
        core = [v for v in range(vertices) if self._round[v] < 0]
        self._core = np.array(core, dtype=np.int64)
        self._number = np.zeros(vertices, dtype=np.int64)
        self._number[self._core] = np.arange(len(self._core))
        rows = [self._back[v] for v in core]
        self._starts = np.concatenate(([0], np.cumsum([len(row) for row in rows]))).astype(np.int64)
        self._ends = self._number[np.array([v for row in rows for v in row], dtype=np.int64)]
        self._seconds = np.array([s for row in rows for s in row.values()], dtype=float)

    @property
    def left(self) -> int:
        """Number of vertices that remain for Dijkstra's algorithm."""
        return len(self._core)

    def _join(self, begin: int, end: int, seconds: float) -> None:
        for links, one, other in ((self._away, begin, end), (self._back, end, begin)):
            if seconds < links[one].get(other, inf):
                links[one][other] = seconds

    def _take_out(self) -> None:
        waiting: Iterable[int] = range(len(self._away))
        while True:
            taken: List[Tuple[int, List[int]]] = []
            touched: Dict[int, None] = {}
            for vertex in waiting:
                near = list(dict.fromkeys((*self._away[vertex], *self._back[vertex])))
                if len(near) <= 2 and vertex not in touched:
                    taken.append((vertex, near))
                    touched.update(dict.fromkeys(near))
            if not taken:
                return
            for vertex, near in taken:
                self._round[vertex] = len(self._rounds)
                self._bridge(vertex, near)
            padded = [(near + [vertex, vertex])[:2] for vertex, near in taken]
            self._rounds.append(_Round(
                np.array([vertex for vertex, _ in taken]), np.array(padded).T,
                np.array([[self._away[vertex].get(other, inf) for other in near]
                          for (vertex, _), near in zip(taken, padded)]).T))
            waiting = touched

    def _bridge(self, vertex: int, near: Sequence[int]) -> None:
        """Removes the links of a vertex with its neighbours, and links its neighbours directly."""
        for neighbour in near:
            self._away[neighbour].pop(vertex, None)
            self._back[neighbour].pop(vertex, None)
        for begin, before in self._back[vertex].items():
            for end, behind in self._away[vertex].items():
                if begin != end:
                    self._join(begin, end, before + behind)

    def to(self, targets: Sequence[int]) -> np.ndarray:
        """Returns the seconds (T,V) from each vertex to each of T targets.

        Infinite: there is no path.
        """
        return self._paths([self._descents((target,)) for target in targets])

    def to_nearest(self, targets: Iterable[int]) -> np.ndarray:
        """Returns the seconds (V,) from each vertex to its nearest target, in one search."""
        paths: np.ndarray = self._paths([self._descents(targets)])[0]
        return paths

    def _paths(self, descents: Sequence[Dict[int, float]]) -> np.ndarray:
        """Returns the seconds (T,V) from each vertex to the targets of each of T descents."""
        count, core = len(descents), len(self._core)
        # One more node for each descent, linked to the remaining graph.
        rows = [{v: s for v, s in row.items() if self._round[v] < 0} for row in descents]
        starts = self._starts[-1] + np.cumsum([len(row) for row in rows])
        ends = self._number[np.array([v for row in rows for v in row], dtype=np.int64)]
        seconds = [s for row in rows for s in row.values()]
        links = csr_matrix((np.concatenate((self._seconds, seconds)),
                            np.concatenate((self._ends, ends)),
                            np.concatenate((self._starts, starts))),
                           shape=(core + count, core + count))
        paths = np.full((count, len(self._away)), inf)
        paths[:, self._core] = dijkstra(links, indices=np.arange(core, core + count))[:, :core]
        for row, descent in zip(paths, descents):
            below = [v for v in descent if self._round[v] >= 0]
            row[below] = [descent[v] for v in below]
        for vertices, neighbours, to_them in reversed(self._rounds):
            further = (paths[:, neighbours] + to_them).min(axis=1)
            paths[:, vertices] = np.minimum(paths[:, vertices], further)
        return paths

    def _descents(self, targets: Iterable[int]) -> Dict[int, float]:
        """Returns, for each vertex with a descending path to a target, the seconds to the nearest
        target.

        Each step of a descending path leads to a vertex that was removed in an earlier round.
        """
        found = dict.fromkeys(targets, 0.0)
        waiting = sorted((self._round[target], target) for target in found)
        while waiting:
            number, vertex = heappop(waiting)
            if number < 0:
                continue
            for above, seconds in self._back[vertex].items():
                if above not in found:
                    heappush(waiting, (self._round[above], above))
                found[above] = min(found[vertex] + seconds, found.get(above, inf))
        return found
