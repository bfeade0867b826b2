"""Finds straight lanes between places at which robots can turn, and the costs of these lanes."""
from __future__ import annotations

import math
from typing import Iterator, NamedTuple, Set, Tuple

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from graph_editor.floor import EVERY_NEIGHBOUR, Floor
from graph_editor.making.coverage import CLOSED
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import straight

LONGEST = 3.0  # m; largest length of a lane between two places to turn
PIECE = 0.5  # m; an additional lane costs as much as this length of path
TIGHTNESS = 4.0  # m; one metre less clearance costs as much as this length of path
AWAY = 8.0  # m; paths are searched within this distance of the points to connect
JUMP = 2.0  # m; largest length of a lane from one part of the floor for turning to another


class Margin(NamedTuple):
    """The least clearances (m): at places to turn, and along lanes."""

    turning: float
    straight: float


def margins_of(options: MakingOptions) -> Tuple[Margin, ...]:
    """Returns margins in descending order.

    All other lanes have the first margin. The last margin is the smallest with which a robot's own
    path search works.
    """
    return (Margin(options.turning, options.tight),
            Margin(options.least_turning, options.tight),
            Margin(options.least_turning, options.robot_width / 2.0 + options.margin / 2.0))


def places_to_turn(floor: Floor, low: np.ndarray, high: np.ndarray,
                   margin: Margin) -> np.ndarray:
    """Returns the places to turn (N,2) in the rectangle from `low` to `high`."""
    (top, bottom), (left, right) = floor.cells_of(np.array((low, high)))
    rows, columns = np.nonzero(floor.clearance[top:bottom + 1, left:right + 1]
                               >= margin.turning)
    return floor.centres(rows + top, columns + left)


def straights(floor: Floor, places: np.ndarray, ends: int, margin: Margin,
              options: MakingOptions) -> Tuple[np.ndarray, np.ndarray]:
    """Returns the costs (N,N) of lanes between places, and their clearances (N,N), m.

    The cost is 0 if no lane is possible. Lanes from the first `ends` places may have any length.
    """
    costs = np.zeros((len(places), len(places)))
    clearances = np.zeros_like(costs)
    first, second = np.triu_indices(len(places), 1)
    lengths = np.linalg.norm(places[second] - places[first], axis=1)
    for chosen in (first < ends, (first >= ends) & (lengths < LONGEST)):
        a, b, length = first[chosen], second[chosen], lengths[chosen]
        room = room_between(floor, places[a], places[b])
        clearances[a, b] = clearances[b, a] = room
        free = room >= margin.straight
        costs[a[free], b[free]] = price(length, room, options)[free]
    return costs, clearances


def room_between(floor: Floor, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Returns the least clearance (N,; m) on each straight line from `starts` to `ends` (N,2).

    starts -- one point for all lines, or (N,2)
    """
    longest = np.linalg.norm(ends - starts, axis=1).max(initial=0.0)
    room = np.full(len(ends), np.inf)
    for fraction in np.linspace(0.0, 1.0, int(math.ceil(longest / floor.resolution)) + 1):
        room = np.minimum(room, floor.clearance_at(starts + fraction * (ends - starts)))
    return room


def price(length: np.ndarray, room: np.ndarray, options: MakingOptions) -> np.ndarray:
    """Returns the costs (N,), m, of lanes with the given lengths (N,) and clearances (N,)."""
    return length + PIECE + TIGHTNESS * (options.wide - np.minimum(room, options.wide))


def ways_to_drive(floor: Floor, margin: Margin, options: MakingOptions,
                  points: np.ndarray) -> np.ndarray:
    """Returns the cost (rows, columns) of a path through each cell; narrow cells cost more.

    A cell is open if robots can turn on it, or if it is on the cheapest straight lane between two
    nearby parts of the floor on which robots can turn. All other cells are CLOSED. Cells more than
    AWAY m outside the box around points (N,2) are also CLOSED.
    """
    (top, bottom), (left, right) = floor.cells_of(
        np.array((points.min(axis=0) - AWAY, points.max(axis=0) + AWAY)))
    window = slice(top, bottom + 1), slice(left, right + 1)
    turning = np.zeros(floor.clearance.shape, bool)
    turning[window] = floor.clearance[window] >= margin.turning
    costs = np.where(turning, 1.0 + TIGHTNESS * np.maximum(1.0 - floor.clearance, 0.0), CLOSED)
    for start, end in _jumps(floor, turning, margin, options):
        cells = floor.cells_of(straight(floor, start, end))
        costs[cells] = np.maximum(costs[cells], 1.0 + TIGHTNESS)
    return costs


def _jumps(floor: Floor, turning: np.ndarray, margin: Margin,
           options: MakingOptions) -> Iterator[Tuple[np.ndarray, np.ndarray]]:
    """Yields for each two nearby parts of the floor the cheapest straight lane: its start and end.
    """
    parts, _ = ndimage.label(turning, EVERY_NEIGHBOUR)
    rim = np.nonzero(turning & ~ndimage.binary_erosion(turning, EVERY_NEIGHBOUR))
    places, part = floor.centres(*rim), parts[rim]
    pairs = cKDTree(places).query_pairs(JUMP, output_type='ndarray')
    pairs = pairs[part[pairs[:, 0]] != part[pairs[:, 1]]]
    middles = (places[pairs[:, 0]] + places[pairs[:, 1]]) / 2.0
    pairs = pairs[floor.clearance_at(middles) >= margin.straight]
    starts, ends = places[pairs[:, 0]], places[pairs[:, 1]]
    room = room_between(floor, starts, ends)
    prices = price(np.linalg.norm(ends - starts, axis=1), room, options)
    joined: Set[Tuple[int, int]] = set()
    for k in np.argsort(prices, kind='stable'):
        first, second = sorted(part[pairs[k]].tolist())
        if room[k] >= margin.straight and (first, second) not in joined:
            joined.add((first, second))
            yield starts[k], ends[k]
