"""Lanes as curves: ways between junctions in driving order, with splines for corners where two meet.

Junctions stay corners, right angles right: there robots may go either way. Elsewhere a robot that
must turn shall not have to stop for it.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Collection, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from graph_editor.making.lanes import LaneNet
from graph_editor.making.sight import TOLERANCE
from trajectory_graph.curves import cubic_bezier

LEAST_TURN = math.radians(6.0)
MOST_TURN = math.radians(120.0)  # beyond: a robot turns on the spot
FROM_CORNER = 0.42  # m between a spline and the corner that it takes the place of, at most
LONGEST_TANGENT, SHORTEST_TANGENT = 3.0, 0.35  # m from the corner to where the spline begins
SHARE = 0.45  # of a lane that one spline may take


@dataclass(frozen=True, eq=False)
class Piece:
    """A straight lane, or a spline, between two places (m); `need` m must stay free around it."""

    start: np.ndarray
    end: np.ndarray
    need: float
    control: Optional[np.ndarray] = None
    """(4,2) control points of a spline; None for a straight lane."""


@dataclass(frozen=True, eq=False)
class Way:
    """What leads from one node to another without a junction between, in driving order."""

    first: int
    last: int
    pieces: Tuple[Piece, ...]

    def turned_round(self) -> Way:
        """The same, driven the other way."""
        return Way(self.last, self.first, tuple(
            Piece(piece.end, piece.start, piece.need,
                  None if piece.control is None else piece.control[::-1])
            for piece in reversed(self.pieces)))


def ways_of(net: LaneNet, places: Collection[int]) -> List[Way]:
    """All lanes of `net` as ways between junctions, dead ends and `places`."""
    return [Way(nodes[0], nodes[-1], tuple(_pieces(net, nodes)))
            for nodes in _runs(net, set(places))]


def _runs(net: LaneNet, places: set) -> Iterator[List[int]]:
    stops = [node for node in net.nodes if net.degree(node) != 2 or node in places]
    if not stops and net.nodes:
        stops = [min(net.nodes)]
    driven = set()
    for stop in stops:
        for neighbour in net.neighbours(stop):
            if net.lane(stop, neighbour).nodes in driven:
                continue
            run = [stop, neighbour]
            while run[-1] not in stops:
                onward, = (node for node in net.neighbours(run[-1]) if node != run[-2])
                run.append(onward)
            driven.update(net.lane(a, b).nodes for a, b in zip(run, run[1:]))
            if run[0] == run[-1] and len(run) > 2:  # a ring: no vertex joins to itself
                yield run[:-1]
                yield [run[-2], run[-1]]
            else:
                yield run


def _pieces(net: LaneNet, nodes: Sequence[int]) -> Iterator[Piece]:
    here = net.positions[nodes[0]]
    for before, corner, after in zip(nodes, nodes[1:], nodes[2:]):
        need = net.lane(before, corner).need
        spline = _rounded(net, before, corner, after)
        if spline is None:
            yield Piece(here, net.positions[corner], need)
            here = net.positions[corner]
            continue
        if np.hypot(*(spline[0] - here)) > 1e-3:
            yield Piece(here, spline[0], need)
        yield Piece(spline[0], spline[3], min(need, net.lane(corner, after).need), spline)
        here = spline[3]
    yield Piece(here, net.positions[nodes[-1]], net.lane(nodes[-2], nodes[-1]).need)


def _rounded(net: LaneNet, before: int, corner: int, after: int) -> Optional[np.ndarray]:
    """Control points of the spline around a corner, or None where it stays a corner."""
    a, b, c = (net.positions[node] for node in (before, corner, after))
    lengths = np.hypot(*(b - a)), np.hypot(*(c - b))
    arriving, leaving = (b - a) / lengths[0], (c - b) / lengths[1]
    turn = math.acos(max(-1.0, min(1.0, float(arriving @ leaving))))
    if not LEAST_TURN < turn < MOST_TURN:
        return None
    need = min(net.lane(before, corner).need, net.lane(corner, after).need)
    tangent = min(FROM_CORNER / math.tan(turn / 4.0), LONGEST_TANGENT, SHARE * min(lengths))
    while tangent >= SHORTEST_TANGENT:
        handle = tangent * 4.0 / 3.0 * math.tan(turn / 4.0) / math.tan(turn / 2.0)
        start, end = b - tangent * arriving, b + tangent * leaving
        control = np.array((start, start + handle * arriving, end - handle * leaving, end))
        points = cubic_bezier(control).sample(net.floor.resolution)
        if net.floor.clearance_at(points).min() >= need - TOLERANCE:
            return control
        tangent *= 0.7
    return None


def headings(way: Way) -> Dict[int, float]:
    """Driving direction (rad) at the way's first and last node."""
    def direction(start: np.ndarray, end: np.ndarray) -> float:
        return math.atan2(end[1] - start[1], end[0] - start[0])
    return {way.first: direction(way.pieces[0].start, way.pieces[0].end),
            way.last: direction(way.pieces[-1].start, way.pieces[-1].end)}
