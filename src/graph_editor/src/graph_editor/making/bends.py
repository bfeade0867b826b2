"""Converts lanes to curves. The result is paths between junctions, in which bends are splines.

- Junctions stay corners with right angles, because robots may drive in each direction there.
- At other corners a spline lets a robot turn without a stop.
- Through a narrow door a robot drives straight; it turns before and after the door. So no vertex is
  in a door, and the narrow corridor is short.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Collection, Iterator, List, Optional, Sequence, Set, Tuple

import numpy as np

from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import TOLERANCE
from trajectory_graph.curves import cubic_bezier

LEAST_TURN = math.radians(6.0)
MOST_TURN = math.radians(120.0)  # at a larger angle a robot turns on the spot
FROM_CORNER = 0.42  # m; largest distance between a spline and the corner that it replaces
LONGEST_TANGENT, SHORTEST_TANGENT = 3.0, 0.35  # m; from a corner to the start of its spline
SHARE = 0.45  # share of a lane that a spline may use if the lane's other end is a junction
SHORTEST_LANE = 0.4  # m; shortest lane between two splines


@dataclass(frozen=True, eq=False)
class Piece:
    """A straight lane or a spline between two points (m); `need` is the clearance (m) that it
    needs.
    """

    start: np.ndarray
    end: np.ndarray
    need: float
    control: Optional[np.ndarray] = None
    """(4,2) control points of a spline; None for a straight lane."""


@dataclass(frozen=True, eq=False)
class LaneWay:
    """A path from one node to another, without a junction between them; pieces are in driving
    order.
    """

    first: int
    last: int
    pieces: Tuple[Piece, ...]

    def turned_round(self) -> LaneWay:
        """Returns the path in the opposite direction."""
        return LaneWay(self.last, self.first, tuple(
            Piece(piece.end, piece.start, piece.need,
                  None if piece.control is None else piece.control[::-1])
            for piece in reversed(self.pieces)))


def ways_of(net: LaneNet, places: Collection[int], options: MakingOptions) -> List[LaneWay]:
    """Returns all lanes of `net` as paths between junctions, dead ends and `places`."""
    return [LaneWay(nodes[0], nodes[-1], tuple(_pieces(net, nodes, options)))
            for nodes in _runs(net, set(places))]


def _runs(net: LaneNet, places: Set[int]) -> Iterator[List[int]]:
    stops = [node for node in net.nodes if net.degree(node) != 2 or node in places]
    if not stops and net.nodes:
        stops = [min(net.nodes)]
    driven: Set[Tuple[int, int]] = set()
    for stop in stops:
        for neighbour in net.neighbours(stop):
            if net.lane(stop, neighbour).nodes in driven:
                continue
            run = [stop, neighbour]
            while run[-1] not in stops:
                onward, = (node for node in net.neighbours(run[-1]) if node != run[-2])
                run.append(onward)
            driven.update(net.lane(a, b).nodes for a, b in zip(run, run[1:]))
            if run[0] == run[-1] and len(run) > 2:  # a ring: no edge may join a vertex to itself
                yield run[:-1]
                yield [run[-2], run[-1]]
            else:
                yield run


def _pieces(net: LaneNet, nodes: Sequence[int], options: MakingOptions) -> Iterator[Piece]:
    corners = [net.positions[node] for node in nodes]
    needs = [net.lane(a, b).need for a, b in zip(nodes, nodes[1:])]
    here = corners[0]
    for k, tangent in enumerate(_tangents(net, corners, needs, options), 1):
        if not tangent:
            yield Piece(here, corners[k], needs[k - 1])
            here = corners[k]
            continue
        spline = _spline(corners[k - 1:k + 2], tangent)
        if np.hypot(*(spline[0] - here)) > SHORTEST_LANE / 2.0:
            yield Piece(here, spline[0], needs[k - 1])
        else:
            spline[0] = here
        yield Piece(spline[0], spline[3], min(needs[k - 1:k + 1]), spline)
        here = spline[3]
    yield Piece(here, corners[-1], needs[-1])


def _tangents(net: LaneNet, corners: Sequence[np.ndarray], needs: Sequence[float],
              options: MakingOptions) -> List[float]:
    """Returns the tangent (m) at each inner corner: the distance from the corner to both ends of
    its spline; 0: no spline.

    Two splines either touch, or have a lane of at least SHORTEST_LANE between them.
    """
    lengths = [float(np.hypot(*(b - a))) for a, b in zip(corners, corners[1:])]
    inner = len(corners) - 2
    limits = [min(length * (0.5 if 0 < k < inner else SHARE) for k, length in (
        (k, lengths[k]), (k + 1, lengths[k + 1]))) for k in range(inner)]
    rooms = [net.floor.clearance_of(corner) for corner in corners]
    turning = [min(options.turning, room) if room >= options.least_turning else 0.0
               for room in rooms]
    tangents = [_tangent(net, corners[k:k + 3], max(min(needs[k:k + 2]), turning[k + 1]), limits[k])
                for k in range(inner)]
    for k in range(1, inner):
        between = lengths[k] - tangents[k - 1] - tangents[k]
        if tangents[k - 1] and tangents[k] and 1e-6 < between < SHORTEST_LANE:
            for corner in (k - 1, k):
                shorter = tangents[corner] - (SHORTEST_LANE - between) / 2.0
                tangents[corner] = shorter if shorter >= SHORTEST_TANGENT else 0.0
    return tangents


def _tangent(net: LaneNet, corners: Sequence[np.ndarray], need: float, limit: float) -> float:
    """Returns the longest tangent (m) with which a spline fits at the middle corner of three; 0:
    none fits.
    """
    turn = turn_of(corners)
    if not LEAST_TURN < turn < MOST_TURN:
        return 0.0
    tangent = min(FROM_CORNER / math.tan(turn / 4.0), LONGEST_TANGENT, limit)
    while tangent >= SHORTEST_TANGENT:
        points = cubic_bezier(_spline(corners, tangent)).sample(net.floor.resolution)
        if net.floor.clearance_at(points).min() >= need - TOLERANCE:
            return tangent
        tangent *= 0.8
    return 0.0


def turn_of(corners: Sequence[np.ndarray]) -> float:
    """Returns the angle (rad, 0 or more) by which a path turns at the middle of three corners."""
    a, b, c = corners
    lengths = float(np.hypot(*(b - a)) * np.hypot(*(c - b)))
    cosine = float((b - a) @ (c - b)) / max(lengths, 1e-12)
    return math.acos(max(-1.0, min(1.0, cosine)))


def _spline(corners: Sequence[np.ndarray], tangent: float) -> np.ndarray:
    """Returns the control points (4,2) of a spline that is almost an arc of a circle."""
    a, b, c = corners
    arriving, leaving = (b - a) / np.hypot(*(b - a)), (c - b) / np.hypot(*(c - b))
    turn = turn_of(corners)
    handle = tangent * 4.0 / 3.0 * math.tan(turn / 4.0) / math.tan(turn / 2.0)
    start, end = b - tangent * arriving, b + tangent * leaving
    return np.array((start, start + handle * arriving, end - handle * leaving, end))
