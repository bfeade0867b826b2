"""One robot in a planning problem: the fixed part of its path, and what it still has to do."""
from __future__ import annotations

from math import inf
from typing import FrozenSet, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from fleet_core.fleet import RobotType
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.plans import Arrival, Drive, Plan
from fleet_core.planning.road_network import RoadNetwork, Roads, estimated

LATER = 1e-4
"""Weight of a second on the way to parking; a second on the way to the destinations weighs 1."""


class PathQuery:
    """What one robot has to do, with all data that a search for its path needs.

    The searches read each attribute in their inner loops, so nothing is derived there.

    vertex       -- where it starts; -1: between two vertices
    origins      -- {vertex: seconds}: where it can go on from, and the time to get there; for a
                    robot between two vertices these are the vertices to which it may drive
    ready        -- s before which it does not start
    destinations -- vertices to visit in order
    legs         -- number of its destinations
    dwells       -- s to stay at each destination
    rests        -- vertices at which it may end for ever; None: at the last destination
    later        -- weight of the seconds after the last destination; 0 without rests
    common       -- rests that it shares with other queries
    """

    def __init__(self, network: RoadNetwork, kind: RobotType, vertex: int,
                 origins: Mapping[int, float], ready: float, destinations: Sequence[int],
                 dwells: Sequence[float] = (), rests: Optional[FrozenSet[int]] = None,
                 later: float = LATER, common: FrozenSet[int] = frozenset()) -> None:
        self.network = network
        self.vertex = vertex
        self.start: Arrival = (-1, 0.0, vertex, ready)
        """Its arrival where it stands, without a drive."""
        self.origins = origins
        self.ready = ready
        self.destinations = tuple(destinations)
        self.legs = len(self.destinations)
        self.dwells = tuple(dwells) or (0.0,) * self.legs
        self.rests = rests
        self.later = later if rests is not None else 0.0
        docks = self.destinations if rests is None else (*self.destinations, *rests)
        self.roads: Roads = network.roads(kind, docks)
        self.to_go: List[Sequence[float]] = []
        """For each leg, the seconds from each vertex over all later destinations to the last one.

        One more entry follows: the seconds to the nearest rest, or 0 without rests.
        """
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
        """The lowest cost of the robot without traffic; infinite: something is unreachable."""
        if rests is not None:
            nearest = network.paths_to_nearest(kind, rests, common)
            self.to_go.append(estimated(nearest))
            self.lower_bound += later * (float(nearest[self.destinations[-1]]) if paths
                                         else self.seconds_to(nearest))
        else:
            self.to_go.append([0.0] * len(self.roads))

    def seconds_to(self, path: np.ndarray) -> float:
        """Returns the seconds from its start to a target, without traffic.

        path -- the seconds from each vertex to the target
        """
        return min((seconds + float(path[vertex]) for vertex, seconds in self.origins.items()),
                   default=inf)

    def served_at(self, vertex: int, leg: int, arrival: float) -> Tuple[float, int]:
        """Returns when it may leave a vertex, and its next leg.

        It serves each destination on arrival.
        """
        while leg < self.legs and self.destinations[leg] == vertex:
            arrival += self.dwells[leg]
            leg += 1
        return arrival, leg

    def serve(self, leg: int, served: float, arrival: float,
              until: float) -> Tuple[int, float, float]:
        """Serves the destination of a leg, and each later one at this vertex, while it is free.

        Returns the next leg, the time of the last service, and when the robot may leave.
        """
        targets, leaves = self.destinations, arrival
        here, last = targets[leg], len(targets) - 1
        while leg <= last and targets[leg] == here:
            done = leaves + self.dwells[leg]
            if done > until or (self.rests is None and leg == last and until < inf):
                break
            leaves = served = done
            leg += 1
        return leg, served, leaves

    def may_rest(self, vertex: int, until: float) -> bool:
        """Returns whether the robot may stay at this vertex after its last destination.

        until -- time until which the vertex is free
        """
        return self.rests is None or (until == inf and vertex in self.rests)

    def cost(self, plan: Sequence[Drive]) -> float:
        """Returns the cost of a plan that answers the query.

        Infinite: the plan does not answer it.
        """
        vertex = self.vertex
        now, leg = self.served_at(vertex, 0, self.ready)
        served = now
        for drive in plan:
            before = leg
            vertex = self.network.destination(drive.drive)
            now, leg = self.served_at(vertex, leg, drive.end)
            if leg > before:
                served = now
        if leg < self.legs:
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
    """Where it stands before it drives anything; unused if `fixed` begins within a drive."""
    fixed: Tuple[Drive, ...]
    """The drives, with times, that belong to each possible plan."""
    query: PathQuery
    priority: int = 0
    mid_edge: Optional[MidEdgePosition] = None
    """Where it stands between two vertices, if it does. Then nothing is fixed."""

    def whole(self, plan: Plan) -> Plan:
        """Returns all drives: the fixed ones and those of the plan."""
        return [*self.fixed, *plan]
