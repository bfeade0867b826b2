"""One robot in a planning problem: what is fixed of its path, and what it still has to do."""
from __future__ import annotations

from math import inf
from typing import FrozenSet, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.planning.plans import Drive, Plan
from graph_fleet_manager.planning.reservation_table import MidEdgePosition
from graph_fleet_manager.planning.road_network import RoadNetwork, Roads, estimated

LATER = 1e-4
"""What a second on the way to parking weighs against one on the way to the destinations."""


class Errand:
    """What one robot has to do, with all that a search needs to know of the path.

    vertex       -- at which it sets out; -1: between two vertices
    origins      -- {vertex: seconds}: where it can go on from, and how long it takes to come there;
                    for a robot between two vertices those to which it may drive
    ready        -- s before which it does not set out
    destinations -- vertices to visit in order
    dwells       -- s to stay at each
    rests        -- vertices at which it may end for ever; None: at the last destination
    later        -- weight of the seconds after the last destination
    common       -- rests that other errands have, too
    """

    def __init__(self, network: RoadNetwork, kind: RobotType, vertex: int,
                 origins: Mapping[int, float], ready: float, destinations: Sequence[int],
                 dwells: Sequence[float] = (), rests: Optional[FrozenSet[int]] = None,
                 later: float = LATER, common: FrozenSet[int] = frozenset()) -> None:
        self.network = network
        self.vertex = vertex
        self.origins = origins
        self.ready = ready
        self.destinations = tuple(destinations)
        self.dwells = tuple(dwells) or (0.0,) * len(self.destinations)
        self.rests = rests
        self.later = later
        docks = self.destinations if rests is None else (*self.destinations, *rests)
        self.roads: Roads = network.roads(kind, docks)
        self.to_go: List[Sequence[float]] = []
        """For each leg, the seconds from every vertex over all destinations left to the last;
        behind them one more where there are rests: to the nearest of these."""
        beyond = 0.0
        paths = network.paths_to(kind, self.destinations)
        for leg in range(len(paths) - 1, -1, -1):
            beyond += self.dwells[leg]
            self.to_go.insert(0, estimated(paths[leg] + beyond) if beyond
                              else network.estimates(kind, self.destinations[leg]))
            if leg:
                beyond += float(paths[leg][self.destinations[leg - 1]])
        if paths:
            beyond += self.seconds_to(paths[0])
        self.lower_bound = ready + beyond
        """The least cost of the robot alone; infinite where something is out of reach."""
        if rests is not None:
            nearest = network.paths_to_nearest(kind, rests, common)
            self.to_go.append(estimated(nearest))
            self.lower_bound += later * (float(nearest[self.destinations[-1]]) if paths
                                         else self.seconds_to(nearest))

    def seconds_to(self, path: np.ndarray) -> float:
        """Seconds to a target from where it sets out, alone; `path`: those from every vertex."""
        return min((seconds + float(path[vertex]) for vertex, seconds in self.origins.items()),
                   default=inf)

    def served_at(self, vertex: int, leg: int, arrival: float) -> Tuple[float, int]:
        """When it may go on from a vertex, and its next leg: it serves what it comes to."""
        while leg < len(self.destinations) and self.destinations[leg] == vertex:
            arrival += self.dwells[leg]
            leg += 1
        return arrival, leg

    def cost(self, plan: Sequence[Drive]) -> float:
        """What a plan costs that serves it; infinite for one that does not."""
        vertex = self.vertex
        now, leg = self.served_at(vertex, 0, self.ready)
        served = now
        for drive in plan:
            before = leg
            vertex = self.network.destination(drive.drive)
            now, leg = self.served_at(vertex, leg, drive.end)
            if leg > before:
                served = now
        if leg < len(self.destinations):
            return inf
        if self.rests is None:
            return now if not self.destinations or vertex == self.destinations[-1] else inf
        if vertex not in self.rests:
            return inf
        return served + self.later * (now - served)


class Agent(NamedTuple):
    """One robot of a planning problem."""

    name: str
    kind: RobotType
    vertex: int
    """Where it stands before it drives anything; of no meaning where `fixed` begins in a drive."""
    fixed: Tuple[Drive, ...]
    """What it will drive under every plan, timed."""
    errand: Errand
    priority: int = 0
    mid_edge: Optional[MidEdgePosition] = None
    """Where it stands if it is between two vertices; then nothing is fixed."""

    def whole(self, plan: Plan) -> Plan:
        """What it drives in all."""
        return [*self.fixed, *plan]
