"""Straight lanes between places where robots can turn: where they can lead, and what they cost."""
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

LONGEST = 3.0  # m of a lane between two of them
PIECE = 0.5  # m of way that one more lane costs
TIGHTNESS = 4.0  # m of way that a metre of clearance is worth
AWAY = 8.0  # m around what ways shall join, within which they are looked for
JUMP = 2.0  # m of a straight between parts of the floor to turn on, at most


class Margin(NamedTuple):
    """Clearances, m: of places to turn, and along lanes."""

    turning: float
    straight: float


def margins_of(options: MakingOptions) -> Tuple[Margin, ...]:
    """From what lanes have elsewhere to the least that a robot's own search for a way needs."""
    return (Margin(options.turning, options.tight),
            Margin(options.least_turning, options.tight),
            Margin(options.least_turning, options.robot_width / 2.0 + options.margin / 2.0))


def places_to_turn(floor: Floor, low: np.ndarray, high: np.ndarray,
                   margin: Margin) -> np.ndarray:
    """(N,2) the places to turn between two corners."""
    (top, bottom), (left, right) = floor.cells_of(np.array((low, high)))
    rows, columns = np.nonzero(floor.clearance[top:bottom + 1, left:right + 1]
                               >= margin.turning)
    return floor.centres(rows + top, columns + left)


def straights(floor: Floor, places: np.ndarray, ends: int, margin: Margin,
              options: MakingOptions) -> Tuple[np.ndarray, np.ndarray]:
    """(N,N) costs of lanes between places, 0 where none can lead; and their clearances (m).

    Lanes from the first places, the `ends`, may be of any length.
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
    """(N,) m: the least clearance on each straight from `starts`, one or (N,2), to `ends` (N,2)."""
    longest = np.linalg.norm(ends - starts, axis=1).max(initial=0.0)
    room = np.full(len(ends), np.inf)
    for fraction in np.linspace(0.0, 1.0, int(math.ceil(longest / floor.resolution)) + 1):
        room = np.minimum(room, floor.clearance_at(starts + fraction * (ends - starts)))
    return room


def price(length: np.ndarray, room: np.ndarray, options: MakingOptions) -> np.ndarray:
    """(N,) m: what lanes of a length (N,) and with some clearance (N,) cost."""
    return length + PIECE + TIGHTNESS * (options.wide - np.minimum(room, options.wide))


def ways_to_drive(floor: Floor, margin: Margin, options: MakingOptions,
                  points: np.ndarray) -> np.ndarray:
    """(rows, columns) what a cell of way costs, the more the narrower; CLOSED to robots.

    Open is the floor on which robots turn, and the best straight from each part of it to each
    other that is near; everything in the box around points (N,2), and AWAY m around that.
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
    """The best straight between each two parts of the floor to turn on that are near by."""
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
