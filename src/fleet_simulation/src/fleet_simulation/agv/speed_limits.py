"""Speed limits along the edges of a graph, and the vertices at which an AGV must stop to turn."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Tuple

import numpy as np

from trajectory_graph import Graph, speed_of

SAMPLE = 0.05   # m; distance between the points at which the bend of a curve is computed
CORNER = 0.05   # rad; up to this change of direction, an AGV need not stop between two edges
CREEP = 0.05    # m/s, lowest speed in a bend
_STEPS = 20     # number of levels to which speeds in bends are rounded down

Stretch = Tuple[float, float]
"""The place at which a speed limit begins (m from the edge's start), and the limit (m/s)."""


@dataclass(frozen=True)
class DriveLimits:
    """The limits of a vehicle's drive; m/s, m/s2, rad/s, rad/s2.

    turn_rate, turn_acceleration -- limits of turns on the spot
    bend_rate -- highest turn rate while the vehicle drives; limits the speed in bends
    reverses  -- whether the vehicle can drive backwards, so that it turns by 90 degrees at most
    """

    speed: float = 1.0
    acceleration: float = 0.5
    braking: float = 0.5
    emergency_braking: float = 2.0
    turn_rate: float = 1.0
    turn_acceleration: float = 2.0
    bend_rate: float = 1.0
    reverses: bool = True


class SpeedLimits:
    """The limits on a graph's edges, for vehicles of one kind."""

    def __init__(self, graph: Graph, drive: DriveLimits, obeys_edge_speed: bool = True) -> None:
        self._graph, self._drive, self._obeys = graph, drive, obeys_edge_speed
        self._stretches: Dict[int, List[Stretch]] = {}
        self._corners: Dict[Tuple[int, int], bool] = {}

    def along(self, edge: int) -> List[Stretch]:
        """Returns the stretches of a signed edge, in driving order.

        Each stretch ends where the next one begins.
        """
        if edge not in self._stretches:
            self._stretches[edge] = self._compute(edge)
        return self._stretches[edge]

    def stops_between(self, edge: int, following: int) -> bool:
        """Returns whether a vehicle must stop between two edges, to turn or to reverse."""
        key = edge, following
        if key not in self._corners:
            self._corners[key] = abs(angle_between(
                self._graph.curve(edge).heading_at(self._graph.curve(edge).length),
                self._graph.curve(following).heading_at(0.0))) > CORNER
        return self._corners[key]

    def _compute(self, edge: int) -> List[Stretch]:
        top = self._drive.speed
        if self._obeys:
            top = min(top, speed_of(self._graph, edge))
        curve = self._graph.curve(edge)
        cells = max(1, math.ceil(curve.length / SAMPLE))
        arcs = np.linspace(0.0, curve.length, cells + 1)
        bends = np.diff(curve.turned(arcs)) / (curve.length / cells)
        allowed = np.minimum(top, self._drive.bend_rate / np.maximum(bends, 1e-9))
        allowed = np.maximum(np.floor(allowed / top * _STEPS) / _STEPS * top, min(CREEP, top))
        stretches: List[Stretch] = []
        for arc, limit in zip(map(float, arcs[:-1]), map(float, allowed)):
            if not stretches or stretches[-1][1] != limit:
                stretches.append((arc, limit))
        return stretches


def angle_between(first: float, second: float) -> float:
    """Returns the angle (rad, -pi..pi) of the turn from the direction `first` to the direction
    `second`.
    """
    return (second - first + math.pi) % (2.0 * math.pi) - math.pi
