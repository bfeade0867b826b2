"""How fast an AGV may be where, on every edge of a graph, and where it must stand still to turn."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Tuple

import numpy as np

from trajectory_graph import Graph

SAMPLE = 0.05   # m between the places at which a curve's bend is looked at
CORNER = 0.05   # rad that two edges may differ in direction where they are driven without a stop
CREEP = 0.05    # m/s, in the sharpest bend
_STEPS = 20     # speeds within a bend are rounded down to so many parts of the highest one

Stretch = Tuple[float, float]
"""Where (m from the edge's start) a speed limit begins, and the limit (m/s)."""


@dataclass(frozen=True)
class DriveLimits:
    """What a vehicle's drive can do; m/s, m/s2, rad/s, rad/s2.

    turn_rate, turn_acceleration -- of turns on the spot
    bend_rate -- of turns while it drives, which limits its speed in bends
    reverses  -- whether it drives backwards as well as forwards, and so turns by 90 degrees at most
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

    def may_drive(self, edge: int) -> bool:
        """May the edge be driven in this direction at all? Not where its speed is 0."""
        return self._edge_speed(edge) > 0.0

    def along(self, edge: int) -> List[Stretch]:
        """The stretches of a signed edge, from its start; each ends where the next one begins."""
        if edge not in self._stretches:
            self._stretches[edge] = self._compute(edge)
        return self._stretches[edge]

    def stops_between(self, edge: int, following: int) -> bool:
        """Must a vehicle stand still at the vertex between two edges, to turn or to reverse?"""
        key = edge, following
        if key not in self._corners:
            self._corners[key] = abs(angle_between(
                self._graph.curve(edge).heading_at(self._graph.curve(edge).length),
                self._graph.curve(following).heading_at(0.0))) > CORNER
        return self._corners[key]

    def _edge_speed(self, edge: int) -> float:
        described = self._graph.edge(edge)
        return described.velocity_forward if edge > 0 else described.velocity_backwards

    def _compute(self, edge: int) -> List[Stretch]:
        top = self._drive.speed
        if self._obeys:
            top = min(top, self._edge_speed(edge))
        curve = self._graph.curve(edge)
        cells = max(1, math.ceil(curve.length / SAMPLE))
        arcs = np.linspace(0.0, curve.length, cells + 1)
        bends = np.diff(curve.turned(arcs)) / (curve.length / cells)
        allowed = np.minimum(top, self._drive.bend_rate / np.maximum(bends, 1e-9))
        allowed = np.maximum(np.floor(allowed / top * _STEPS) / _STEPS * top, min(CREEP, top))
        stretches: List[Stretch] = []
        for arc, limit in zip(arcs[:-1].tolist(), allowed.tolist()):
            if not stretches or stretches[-1][1] != limit:
                stretches.append((arc, limit))
        return stretches


def angle_between(first: float, second: float) -> float:
    """The angle (rad, -pi..pi) to turn by from the direction `first` to `second`."""
    return (second - first + math.pi) % (2.0 * math.pi) - math.pi
