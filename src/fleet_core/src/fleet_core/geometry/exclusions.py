"""Exclusions: the places that two robots may not hold at once, computed once for each graph.

A robot that waits holds a vertex. A robot that drives holds a whole edge, both ends included,
because it may come to rest anywhere on it. The part behind the robot becomes free piece by piece:
each pair of places has a *clear fraction* of the drive, after which the other place is free.

Robots are discs, and the true curves of the edges count. So edges exclude each other if they meet,
run near each other, or cross without a vertex. Vertices exclude edges that pass too near.
"""
from __future__ import annotations

import time
from math import inf
from typing import Dict, FrozenSet, Iterator, List, NamedTuple, Sequence, Tuple, Union, cast

import numpy as np
from scipy.spatial import cKDTree

from fleet_core.geometry.arrays import count_up
from fleet_core.geometry.capsules import time_within
from fleet_core.geometry.pieces import Pieces

ROUNDING = 1e-11  # m: places exactly at the required distance do not exclude each other
_AT_ONCE = 100000  # number of pairs of pieces examined in one step, to bound the memory


class OutOfTime(Exception):
    """The deadline passed before the conflicts were known."""


class Approach(NamedTuple):
    """The places that only one robot may use while it docks or leaves a dock."""

    edges: Dict[int, Tuple[float, float]]  # by place: the part in the approach, in fractions
    vertices: FrozenSet[int]               # not the dock: a docked robot blocks no approach


class Conflicts(NamedTuple):
    """For each place, the places that exclude it at one distance, as rows of a CSR matrix.

    Row p is the slice starts[p]:starts[p + 1] of the other arrays. `forward` and `backward` are the
    fractions of edge p, driven forward or backward, after which `other` is free again. They are 1
    if `other` is not free even at the end of p. For a vertex p they have no meaning.
    """

    starts: np.ndarray     # (P + 1,)
    other: np.ndarray      # (N,) place, ascending within a row
    forward: np.ndarray    # (N,)
    backward: np.ndarray   # (N,)
    transpose: np.ndarray  # (N,) index of the same pair seen from `other`

    def row(self, place: int) -> List[int]:
        """Returns the places that exclude `place`."""
        return cast(List[int], self.other[self.starts[place]:self.starts[place + 1]].tolist())

    def fractions(self, pairs: Union[slice, np.ndarray]) -> Iterator[Tuple[float, float]]:
        """Returns for some pairs the fractions `forward` and `backward`."""
        return zip(cast(List[float], self.forward[pairs].tolist()),
                   cast(List[float], self.backward[pairs].tolist()))


class Conflict(NamedTuple):
    """One place `other` that excludes a place p, as in `Conflicts`.

    forward, backward             -- fractions of edge p after which `other` is free again
    other_forward, other_backward -- fractions of edge `other` after which p is free again
    """

    other: int
    forward: float
    backward: float
    other_forward: float
    other_backward: float


class Exclusions:
    """Conflicts between places, for each distance that two robots must keep.

    pieces     -- the curves of all places
    ends       -- (E,2) vertex places at the origin and the destination of each edge
    vertices   -- number of vertices
    approaches -- approaches of the docks
    alone      -- groups of places; only one robot at a time may be in a group
    """

    def __init__(self, pieces: Pieces, ends: np.ndarray, vertices: int,
                 approaches: Tuple[Approach, ...] = (),
                 alone: Tuple[Tuple[int, ...], ...] = ()) -> None:
        self._pieces = pieces
        self._ends = ends
        self.vertices = vertices
        self.places = vertices + len(ends)
        self._approaches, self._alone = approaches, alone
        self.deadline = inf
        """Monotonic s after which the search for conflicts stops, and `at` raises OutOfTime."""
        self._by_distance: Dict[float, Conflicts] = {}
        self._rows: Dict[Tuple[float, int], List[Conflict]] = {}

    def excluding(self, place: int, distance: float) -> List[Conflict]:
        """Returns the places that exclude one place for robots whose curves must stay `distance` m
        apart.

        The result is a list, because for a single place lists are far faster than arrays.
        """
        row = self._rows.get((distance, place))
        if row is None:
            starts, other, forward, backward, transpose = self.at(distance)
            part = slice(*starts[place:place + 2])
            mirrored = transpose[part]
            row = self._rows[distance, place] = list(map(Conflict._make, zip(*(
                column.tolist() for column in (other[part], forward[part], backward[part],
                                               forward[mirrored], backward[mirrored])))))
        return row

    def at(self, distance: float) -> Conflicts:
        """Returns the conflicts of robots whose curves must stay `distance` m apart."""
        if distance not in self._by_distance:
            self._by_distance[distance] = self._conflicts(distance)
        return self._by_distance[distance]

    def near(self, line: Sequence[Tuple[float, float]],
             distance: float) -> Dict[int, Tuple[float, float]]:
        """Returns the places (vertices and edges) that are nearer than `distance` (m) to a line.

        line -- the points of the line, m; one point is enough

        Each place has two fractions. For an edge they are the start and the end of the part that is
        too near, counted from the origin of the edge. If there are several such parts, they are the
        start of the first one and the end of the last one. For a vertex both are 0.
        """
        pieces = self._pieces
        found: Dict[int, Tuple[float, float]] = {}
        for first, last in zip(line, line[1:] or line):
            start, end = (np.broadcast_to(np.array(point, dtype=float)[:, None],
                                          pieces.start.shape) for point in (first, last))
            entry, exit = time_within(pieces.start, pieces.end, start, end,
                                      distance - ROUNDING + pieces.margin)
            met = np.flatnonzero(entry <= exit)
            share = pieces.ends[met] - pieces.begins[met]
            for place, low, high in zip(map(int, pieces.place[met]),
                                        map(float, pieces.begins[met] + entry[met] * share),
                                        map(float, pieces.begins[met] + exit[met] * share)):
                before = found.get(place, (low, high))
                found[place] = min(before[0], low), max(before[1], high)
        return found

    def kept_free(self, line: Sequence[Tuple[float, float]], distance: float,
                  own: float) -> Dict[int, Tuple[float, float]]:
        """Returns the places that `near` returns for a robot on this line.

        If the robot is at a place of a group in `alone`, also returns all places of that group.

        own -- m; the robot counts as being at each place that is nearer to the line than this
        """
        found = self.near(line, distance)
        if self._alone:
            has = self.near(line, own).keys()
            for group in self._alone:
                if not has.isdisjoint(group):
                    found.update(dict.fromkeys(group, (0.0, 1.0)))
        return found

    def _conflicts(self, distance: float) -> Conflicts:
        pairs = _Pairs(self.places)
        lengths = _lengths(self._pieces)
        lengths = lengths[lengths > 0.0]
        longest = max(float(np.median(lengths)) if len(lengths) else 0.0, 1.5 * distance, 1e-3)
        pieces = _cut(self._pieces, longest)
        stretches = _stretches(pieces, longest)
        one, other = _candidates(stretches, distance)
        combinations = stretches.pieces[one] * stretches.pieces[other]
        blocks = np.cumsum(combinations) // _AT_ONCE
        begins = [int(k) for k in np.flatnonzero(np.diff(blocks, prepend=-1))]
        for begin, end in zip(begins, [*begins[1:], len(one)]):
            if time.monotonic() > self.deadline:
                raise OutOfTime()
            for met in _near(pieces, stretches, one[begin:end], other[begin:end], distance):
                pairs.add(*met)
        all_places = np.arange(self.places)
        pairs.add(all_places, all_places, np.zeros(self.places), np.ones(self.places))
        for approach in self._approaches:
            pairs.add(*_within_approach(approach))
        for group in self._alone:
            places = np.array(group, dtype=np.int64)
            pairs.add(np.repeat(places, len(group)), np.tile(places, len(group)),
                      np.zeros(len(group) ** 2), np.ones(len(group) ** 2))
        pairs.merge()
        pairs.add(*self._at_ends(pairs))
        pairs.merge()
        pairs.make_symmetric()
        return pairs.conflicts()

    def _at_ends(self, pairs: _Pairs) -> Tuple[np.ndarray, ...]:
        """Returns pairs for the edges at each vertex: a place that excludes the vertex also
        excludes that end of these edges.

        Geometry gives the same result except for rounding, but the searches need it exactly.
        """
        ends = self._ends.ravel()  # [2 * edge]: its origin; [2 * edge + 1]: its destination
        by_vertex = np.argsort(ends, kind='stable')
        counts = np.bincount(ends, minlength=self.vertices)
        firsts = np.concatenate(([0], np.cumsum(counts)))
        at_vertex = pairs.place < self.vertices
        vertex, other = pairs.place[at_vertex], pairs.other[at_vertex]
        repeats = counts[vertex]
        end = by_vertex[np.repeat(firsts[vertex], repeats) + count_up(repeats)]
        edge, other = self.vertices + end // 2, np.repeat(other, repeats)
        different = edge != other
        fraction = (end % 2).astype(float)[different]
        return edge[different], other[different], fraction, fraction


class _Pairs:
    """A growing set of ordered pairs of places: `place` excludes `other`.

    Of `place`, only the part from the fraction `low` to the fraction `high` excludes `other`.
    """

    def __init__(self, places: int) -> None:
        self._places = places
        self.place = self.other = np.zeros(0, dtype=np.int64)
        self.low: np.ndarray = np.zeros(0)
        self.high: np.ndarray = np.zeros(0)
        self._new: List[Tuple[np.ndarray, ...]] = []

    def add(self, place: np.ndarray, other: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
        if len(place):
            self._new.append((place, other, low, high))

    def merge(self) -> None:
        """Sorts the pairs, and leaves one entry for each pair. Its part covers all parts that were
        added for the pair.
        """
        columns = [(self.place, self.other, self.low, self.high), *self._new]
        place, other, low, high = map(np.concatenate, zip(*columns))
        self._new = []
        key = place.astype(np.int64) * self._places + other
        order = np.argsort(key, kind='stable')
        key, low, high = key[order], low[order], high[order]
        first = np.flatnonzero(np.concatenate(([True], key[1:] != key[:-1]))[:len(key)])
        key = key[first]
        self.place, self.other = key // self._places, key % self._places
        if len(key):
            self.low = np.minimum.reduceat(low, first)
            self.high = np.maximum.reduceat(high, first)

    def make_symmetric(self) -> None:
        """Adds the reverse pairs that rounding left out. An added pair excludes the whole place."""
        key, mirrored = self._keys()
        missing = ~np.isin(mirrored, key)
        if missing.any():
            count = int(missing.sum())
            self.add(self.other[missing], self.place[missing], np.zeros(count), np.ones(count))
            self.merge()

    def conflicts(self) -> Conflicts:
        starts = np.searchsorted(self.place, np.arange(self._places + 1))
        return Conflicts(starts, self.other, self.high, 1.0 - self.low,
                         np.searchsorted(*self._keys()))

    def _keys(self) -> Tuple[np.ndarray, np.ndarray]:
        """Returns a number for each pair, and the number of the reverse of each pair."""
        return (self.place * self._places + self.other,
                self.other * self._places + self.place)


def _cut(pieces: Pieces, longest: float) -> Pieces:
    """Returns the pieces, with those longer than `longest` (m) cut into equal parts."""
    parts = np.maximum(np.ceil(_lengths(pieces) / longest - 1e-9), 1.0).astype(int)
    if parts.max() == 1:
        return pieces
    which = np.repeat(np.arange(len(parts)), parts)
    low = count_up(parts) / parts[which]
    high = (count_up(parts) + 1) / parts[which]
    whole = Pieces(*(column.take(which, axis=-1) for column in pieces))
    path, share = whole.end - whole.start, whole.ends - whole.begins
    return whole._replace(start=whole.start + low * path, end=whole.start + high * path,
                          begins=whole.begins + low * share, ends=whole.begins + high * share)


class _Stretches(NamedTuple):
    """Short runs of pieces, each on one place. Whole runs are compared before their pieces."""

    first: np.ndarray   # (S,) index of the first piece
    pieces: np.ndarray  # (S,) number of pieces
    place: np.ndarray   # (S,)
    middle: np.ndarray  # (2, S) m
    radius: np.ndarray  # (S,) m; this circle around `middle` holds all pieces
    piece_middle: np.ndarray  # (2, N) m, of each piece
    piece_half: np.ndarray    # (N,) m, half of its length
    piece_radius: np.ndarray  # (N,) m; this circle around `piece_middle` holds the piece


def _stretches(pieces: Pieces, longest: float) -> _Stretches:
    """Returns all pieces in stretches of about the length `longest` (m). No piece is longer."""
    lengths = _lengths(pieces)
    along = np.cumsum(lengths) - lengths
    new_place = np.concatenate(([True], pieces.place[1:] != pieces.place[:-1]))
    along -= np.repeat(along[new_place], np.diff(np.flatnonzero(np.append(new_place, True))))
    number = np.floor((along + lengths / 2.0) / longest)
    first = np.flatnonzero(new_place | np.concatenate(([True], np.diff(number) != 0.0)))
    count = np.diff(np.append(first, len(lengths)))
    low = np.minimum.reduceat(np.minimum(pieces.start, pieces.end), first, axis=1)
    high = np.maximum.reduceat(np.maximum(pieces.start, pieces.end), first, axis=1)
    radius = np.hypot(*(high - low)) / 2.0 + np.maximum.reduceat(pieces.margin, first)
    return _Stretches(first, count, pieces.place[first], (low + high) / 2.0, radius,
                      (pieces.start + pieces.end) / 2.0, lengths / 2.0,
                      lengths / 2.0 + pieces.margin)


def _candidates(stretches: _Stretches, distance: float) -> Tuple[np.ndarray, np.ndarray]:
    """Returns pairs of stretches of different places that may come nearer than `distance` (m)."""
    place, middle, radius = stretches.place, stretches.middle, stretches.radius
    one, other = cKDTree(middle.T).query_pairs(2.0 * radius.max() + distance,
                                               output_type='ndarray').T
    near = ((_distance(middle, one, middle, other) <= radius[one] + radius[other] + distance)
            & (place[one] != place[other]))
    return one[near], other[near]


def _lengths(pieces: Pieces) -> np.ndarray:
    return np.hypot(*(pieces.end - pieces.start))


def _distance(points: np.ndarray, one: np.ndarray, others: np.ndarray,
              other: np.ndarray) -> np.ndarray:
    """Returns for each k the distance (m) from points[:, one[k]] to others[:, other[k]]."""
    here: np.ndarray = points.take(one, axis=1)
    there: np.ndarray = others.take(other, axis=1)
    x, y = here - there
    return np.sqrt(x * x + y * y)


def _pairs_of_pieces(stretches: _Stretches, one: np.ndarray, other: np.ndarray,
                     distance: float) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compares pairs of stretches. Returns the pairs of their pieces that may be too near.

    It returns three arrays: the number of the pair of stretches (ascending), the piece of the first
    stretch, the piece of the second one.
    """
    pair = np.repeat(np.arange(len(one)), stretches.pieces[one])
    ours = stretches.first[one][pair] + count_up(stretches.pieces[one])
    whole = other[pair]
    near = (_distance(stretches.piece_middle, ours, stretches.middle, whole)
            < distance + stretches.piece_radius[ours] + stretches.radius[whole])
    pair, ours, whole = pair[near], ours[near], whole[near]
    counts = stretches.pieces[whole]
    theirs = np.repeat(stretches.first[whole], counts) + count_up(counts)
    pair, ours = np.repeat(pair, counts), np.repeat(ours, counts)
    near = (_distance(stretches.piece_middle, ours, stretches.piece_middle, theirs)
            < distance + stretches.piece_radius[ours] + stretches.piece_radius[theirs])
    return pair[near], ours[near], theirs[near]


def _near(pieces: Pieces, stretches: _Stretches, one: np.ndarray, other: np.ndarray,
          distance: float) -> Iterator[Tuple[np.ndarray, ...]]:
    """Yields the pairs of stretches that are too near, in both directions.

    For each pair it yields the two places, and the part of the first place (from, to) that is too
    near to the second one.
    """
    pair, ours, theirs = _pairs_of_pieces(stretches, one, other, distance)
    keep = distance - ROUNDING + pieces.margin[ours] + pieces.margin[theirs]
    half = stretches.piece_half
    apart = _distance(stretches.piece_middle, ours, stretches.piece_middle, theirs)
    for mine, yours in ((ours, theirs), (theirs, ours)):
        entry, exit = np.zeros(len(pair)), np.ones(len(pair))
        # all other pieces lie fully within the distance
        partly = np.flatnonzero(apart + half[mine] >= keep)
        to, of = mine[partly], yours[partly]
        entry[partly], exit[partly] = time_within(
            pieces.start.take(to, axis=1), pieces.end.take(to, axis=1),
            pieces.start.take(of, axis=1), pieces.end.take(of, axis=1), keep[partly])
        met = entry <= exit
        if not met.any():
            continue
        to = mine[met]
        share = pieces.ends[to] - pieces.begins[to]
        first = np.flatnonzero(np.diff(pair[met], prepend=-1))
        yield (pieces.place[to[first]], pieces.place[yours[met][first]],
               np.minimum.reduceat(pieces.begins[to] + entry[met] * share, first),
               np.maximum.reduceat(pieces.begins[to] + exit[met] * share, first))


def _within_approach(approach: Approach) -> Tuple[np.ndarray, ...]:
    """Returns the pairs that make each edge of a dock's approach exclude all other places of the
    approach.
    """
    pairs = [(edge, other, *stretch) for edge, stretch in approach.edges.items()
             for other in (*approach.edges, *approach.vertices) if other != edge]
    place, other, low, high = zip(*pairs) if pairs else ((), (), (), ())
    return (np.array(place, dtype=np.int64), np.array(other, dtype=np.int64),
            np.array(low, dtype=float), np.array(high, dtype=float))
