"""Removes useless parts of a skeleton: spurs into corners, and loops that shorten no path.

A chain stays if it *serves* floor that no other chain serves, or if it saves a detour. Junctions
that are close together are merged into one junction.
"""
from __future__ import annotations

import heapq
from typing import Dict, Iterable, List, Optional

import numpy as np

from graph_editor.making.chains import Chain, ChainGraph
from graph_editor.making.coverage import Coverage
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import in_sight

LEAST_FLOOR = 1.0  # m2; a dead end stays if it alone serves this much floor
LEAST_IN_CORNER = 6.0  # m2; the same for a dead end into a corner, where a bay is better
WORTHWHILE_DETOUR = 9.0  # m; a side of a loop stays if it saves this detour
WORTHWHILE_FLOOR = 3.0  # m2; a side of a loop stays if it alone serves this much floor
NARROW_IS_WORSE = 3.0  # a lane too narrow for a corridor must be more useful by this factor
MERGING = 1.0  # m; junctions within this distance become one if there is little space
DOOR = 0.3  # m; if a path becomes wider again by this much, it has passed a kind of door
AHEAD = 1.5  # m; this part of each chain must be visible from the merged junction


def prune(graph: ChainGraph, coverage: Coverage, options: MakingOptions) -> None:
    """Removes the useless parts of the skeleton; connected parts stay connected."""
    _prune_spurs(graph)
    pruner = _Pruner(graph, coverage, options)
    pruner.prune_dead_ends()
    pruner.open_narrow_loops()
    pruner.prune_dead_ends()
    pruner.prune_loops()
    pruner.prune_dead_ends()


def merge_junctions(graph: ChainGraph, options: MakingOptions) -> None:
    """Merges junctions that are close together, if lanes can lead straight to the merged junction.
    """
    refused = set()
    while True:
        chain = min((chain for chain in graph.chains if _is_short(graph, chain)
                     and chain.id not in refused), key=lambda chain: chain.length, default=None)
        if chain is None:
            return
        if not _contract(graph, chain, options):
            refused.add(chain.id)


def _prune_spurs(graph: ChainGraph) -> None:
    """Removes dead ends that hardly reach beyond the widest free disc around their start.

    All spurs of a junction are removed together: at the end of a corridor there are two spurs into
    its corners, and neither spur is the real end of the corridor.
    """
    while True:
        spurs: Dict[int, List[Chain]] = {}
        for tip, chain in graph.dead_ends():
            if _is_spur(graph, tip, chain):
                spurs.setdefault(chain.other(tip), []).append(chain)
        if not spurs:
            return
        base = min(spurs, key=lambda node: (max(chain.length for chain in spurs[node]), node))
        graph.remove_all(spurs[base])


def _is_spur(graph: ChainGraph, tip: int, chain: Chain) -> bool:
    """Returns whether a dead end is a spur.

    The criterion is how far the free discs along the chain reach beyond the disc at the chain's
    base. A spur into a corner may reach farther than a spur behind a narrow place, like a door.
    """
    clearances = chain.clearances_towards(tip)
    beyond = chain.length + clearances[-1] - clearances[0]
    return beyond < (0.5 * clearances[0] + 0.3 if _widens(tip, chain) else 1.2 * clearances[0])


def _leads_into_corner(tip: int, chain: Chain) -> bool:
    """Returns whether a dead end leads from the middle of a hall into a corner.

    Such a dead end is short and becomes narrower along its whole length.
    """
    clearances = chain.clearances_towards(tip)
    return (clearances[-1] < 0.6 * clearances[0] and chain.length < 2.2 * clearances[0]
            and not _widens(tip, chain))


def _widens(tip: int, chain: Chain) -> bool:
    """Returns whether the path to a dead end's tip becomes wider again, as behind a door."""
    clearances = chain.clearances_towards(tip)
    return float((clearances - np.minimum.accumulate(clearances)).max()) >= DOOR


class _Pruner:
    """Prunes a skeleton. Counts how many chains serve each cell of the floor."""

    def __init__(self, graph: ChainGraph, coverage: Coverage, options: MakingOptions) -> None:
        self._graph = graph
        self._coverage = coverage
        self._options = options
        self._served: Dict[int, np.ndarray] = {}
        self._servants = np.zeros(coverage.mask.size, np.int32)
        self._take_up(graph.chains)

    def prune_dead_ends(self) -> None:
        """Removes dead ends, the least useful first, if other lanes serve almost all floor that
        they serve.
        """
        while True:
            uses = [(self._use_of_dead_end(node, chain), node, chain)
                    for node, chain in self._graph.dead_ends()]
            useless = [entry for entry in uses if entry[0] < 1.0]
            if not useless:
                return
            self._remove(min(useless, key=lambda entry: entry[:2])[2])

    def open_narrow_loops(self) -> None:
        """Cuts loops at their narrowest place, if a whole corridor does not fit there.

        A loop is not cut if the cut would cause a long detour. A ring that is narrow everywhere or
        nowhere is cut in its middle.
        """
        for chain in self._graph.chains:
            if not self._graph.has(chain):
                continue
            if chain.is_ring:
                self._open(chain)
            elif chain.clearance < self._options.corridor / 2.0:
                around = self._graph.way_round(chain)
                limit = NARROW_IS_WORSE * WORTHWHILE_DETOUR
                if around is not None and around - chain.length < limit:
                    self._open(chain)

    def _open(self, chain: Chain) -> List[Chain]:
        """Cuts a chain into two dead ends; see `open_narrow_loops`."""
        narrow = chain.clearances < self._options.corridor / 2.0
        if chain.is_ring and narrow.all() == narrow.any():
            first = last = len(chain.path) // 2
        else:
            first = last = int(np.argmin(chain.clearances))
            while first > 0 and narrow[first - 1]:
                first -= 1
            while last < len(narrow) - 1 and narrow[last + 1]:
                last += 1
        made = self._graph.cut_out(chain, first, last)
        self._exchange(made)
        return made

    def prune_loops(self) -> None:
        """Removes sides of loops, the least useful first.

        A removal can only make the other sides more useful, so a usefulness that was computed
        earlier is a lower bound. It is computed again only when it is the lowest of all.
        """
        waiting = [(0.0, chain.id, chain) for chain in self._graph.chains]
        heapq.heapify(waiting)
        while waiting:
            _, _, chain = heapq.heappop(waiting)
            if not self._graph.has(chain):
                continue
            if chain.is_ring:
                self._open(chain)
                continue
            use = self._use_in_loop(chain)
            if use is None or use >= 1.0:
                continue
            if waiting and use > waiting[0][0]:
                heapq.heappush(waiting, (use, chain.id, chain))
                continue
            for made in self._remove(chain):
                heapq.heappush(waiting, (0.0, made.id, made))

    def _use_of_dead_end(self, tip: int, chain: Chain) -> float:
        """Returns how useful a dead end is; it stays if the result is 1 or more."""
        least = LEAST_IN_CORNER if _leads_into_corner(tip, chain) else LEAST_FLOOR
        return self._floor_of(chain) / self._price(chain) / least

    def _use_in_loop(self, chain: Chain) -> Optional[float]:
        """Returns how useful a side of a loop is; it stays if the result is 1 or more.

        None: no other path connects the ends of the chain.
        """
        around = self._graph.way_round(chain)
        if around is None:
            return None
        saved = max(around - chain.length, 0.0) / WORTHWHILE_DETOUR
        return ((saved + self._floor_of(chain) / WORTHWHILE_FLOOR) / self._price(chain)
                / (0.5 + chain.length / 20.0))

    def _price(self, chain: Chain) -> float:
        return 1.0 if chain.clearance >= self._options.corridor / 2.0 else NARROW_IS_WORSE

    def _floor_of(self, chain: Chain) -> float:
        """Returns the area (m2) that only this chain serves."""
        alone = np.count_nonzero(self._servants[self._served[chain.id]] == 1)
        return alone * self._coverage.cell_area

    def _remove(self, chain: Chain) -> List[Chain]:
        made = self._graph.remove_chain(chain)
        self._exchange(made)
        return made

    def _exchange(self, made: List[Chain]) -> None:
        """Adds the new chains to the counts, and takes the removed chains out of the counts."""
        left = {chain.id for chain in self._graph.chains}
        for id in [id for id in self._served if id not in left]:
            self._servants[self._served.pop(id)] -= 1
        self._take_up(made)

    def _take_up(self, chains: Iterable[Chain]) -> None:
        for chain in chains:
            self._served[chain.id] = self._coverage.covered_by(chain.path)
            self._servants[self._served[chain.id]] += 1


def _is_short(graph: ChainGraph, chain: Chain) -> bool:
    return (not chain.is_ring and graph.degree(chain.start) > 2 and graph.degree(chain.end) > 2
            and chain.length < max(MERGING, 0.8 * float(chain.clearances.max())))


def _contract(graph: ChainGraph, chain: Chain, options: MakingOptions) -> bool:
    """Moves both ends of a chain to its middle if the adjacent chains are visible from there.
    Returns whether the ends were moved.
    """
    steps = np.linalg.norm(np.diff(chain.path, axis=0), axis=1)
    middle = int(np.searchsorted(np.cumsum(steps), chain.length / 2.0)) + 1
    middle = min(middle, len(chain.path) - 1)
    centre = chain.path[middle]
    for node in (chain.start, chain.end):
        for other in graph.chains_at(node):
            if other.id != chain.id and not _sees(graph, centre, other, node, options):
                return False
    start, end = chain.start, chain.end
    graph.drop_chain(chain)
    graph.move_node(start, chain.path[:middle + 1])
    graph.move_node(end, chain.path[::-1][:len(chain.path) - middle])
    graph.unite(start, end)
    return True


def _sees(graph: ChainGraph, centre: np.ndarray, chain: Chain, node: int,
          options: MakingOptions) -> bool:
    """Returns whether a lane can lead straight from the centre to a point on a chain."""
    path = chain.path_from(node)
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))))
    ahead = path[min(int(np.searchsorted(arc, AHEAD)), len(path) - 1)]
    return in_sight(graph.floor, centre, ahead, min(options.wide, chain.clearance))
