"""One robot in a planning problem: the fixed part of its path, and what it still has to do."""
from __future__ import annotations

from functools import cached_property
from math import inf
from typing import FrozenSet, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from fleet_core.fleet import RobotType
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.plans import Arrival, Drive, Plan
from fleet_core.planning.road_network import RoadNetwork, Roads, estimated

LATER = 1e-4
"""Weight of a second on the way to parking; a second on the way to the destinations weighs 1."""


class Rests:
    """The vertices at which an agent's path may end for ever.

    Most of these vertices are common to all robots of a type. Values that depend only on the common
    vertices are computed once for all these robots.

    common -- vertices that are rests of other agents, too
    own    -- further vertices
    """

    def __init__(self, common: FrozenSet[int], own: FrozenSet[int] = frozenset()) -> None:
        self.common, self.own = common, own

    def __contains__(self, vertex: int) -> bool:
        return vertex in self.common or vertex in self.own

    @property
    def whole(self) -> FrozenSet[int]:
        """All vertices of both kinds."""
        return self.common | self.own


class PathQuery:
    """What one robot has to do, with all data that a search for its path needs.

    The searches read the attributes in their inner loops, so all values are computed before a
    search begins. The tables are computed at first use, because a robot that keeps its plan needs
    none.

    vertex       -- where it starts; -1: between two vertices
    origins      -- {vertex: seconds}: the vertices from which its path may begin, and the time to
                    reach each; for a robot between two vertices, the vertices to which it may drive
    ready        -- time (s) before which it does not start
    destinations -- vertices to visit in order
    legs         -- number of its destinations
    dwells       -- s to stay at each destination
    rests        -- where it may end for ever; None: at the last destination
    later        -- weight of the seconds after the last destination; 0 without rests
    """

    def __init__(self, network: RoadNetwork, kind: RobotType, vertex: int,
                 origins: Mapping[int, float], ready: float, destinations: Sequence[int],
                 dwells: Sequence[float] = (), rests: Optional[Rests] = None,
                 later: float = LATER) -> None:
        self.network, self._kind = network, kind
        self.vertex = vertex
        self.start: Arrival = (-1, 0.0, vertex, ready)
        """The first arrival of a search: the robot is at its vertex, without a drive."""
        self.origins = origins
        self.ready = ready
        self.destinations = tuple(destinations)
        self.legs = len(self.destinations)
        self.dwells = tuple(dwells) or (0.0,) * self.legs
        self.rests = rests
        self.later = later if rests is not None else 0.0
        self.roads: Roads = network.roads(kind, [
            dock for dock in network.docks
            if dock in self.destinations or rests is not None and dock in rests])

    @cached_property
    def _paths(self) -> List[np.ndarray]:
        """For each leg, the seconds (V,) from each vertex to the leg's destination."""
        return self.network.paths_to(self._kind, self.destinations)

    @cached_property
    def _beyond(self) -> List[float]:
        """For each leg, the seconds from its destination to the last destination, stays included.
        """
        beyond = 0.0
        found: List[float] = []
        for leg in range(self.legs - 1, -1, -1):
            beyond += self.dwells[leg]
            found.insert(0, beyond)
            if leg:
                beyond += float(self._paths[leg][self.destinations[leg - 1]])
        return found

    @cached_property
    def _to_rests(self) -> List[np.ndarray]:
        """The seconds (V,) from each vertex to the nearest common rest, and to each own rest."""
        if self.rests is None:
            return []
        return [self.network.paths_to_nearest(self._kind, self.rests.common),
                *self.network.paths_to(self._kind, sorted(self.rests.own))]

    @cached_property
    def to_go(self) -> List[Sequence[float]]:
        """For each leg, the seconds from each vertex via the leg's destination to the last
        destination.

        One more entry follows: the seconds to the nearest rest, or 0 without rests.
        """
        to_destinations = [
            estimated(path + beyond) if beyond else self.network.estimates(self._kind, destination)
            for path, beyond, destination in zip(self._paths, self._beyond, self.destinations)]
        to_rest: Sequence[float] = [0.0] * len(self.roads)
        if self._to_rests:
            to_rest = estimated(np.minimum.reduce(self._to_rests))
        return [*to_destinations, to_rest]

    @cached_property
    def lower_bound(self) -> float:
        """The lowest cost of the robot without traffic; infinite: it has no path."""
        bound = self.ready
        if self.legs:
            bound += self._beyond[0] + self.seconds_to(self._paths[0])
        if self._to_rests:
            bound += self.later * min(
                float(path[self.destinations[-1]]) if self.legs else self.seconds_to(path)
                for path in self._to_rests)
        return bound

    def seconds_to(self, path: np.ndarray) -> float:
        """Returns the seconds from the robot's start to a target, without traffic.

        path -- the seconds from each vertex to the target
        """
        return min((seconds + float(path[vertex]) for vertex, seconds in self.origins.items()),
                   default=inf)

    def served_at(self, vertex: int, leg: int, arrival: float) -> Tuple[float, int]:
        """Returns when the robot may leave a vertex at which it arrives, and its next leg.

        It first serves its next destinations that are at this vertex.
        """
        while leg < self.legs and self.destinations[leg] == vertex:
            arrival += self.dwells[leg]
            leg += 1
        return arrival, leg

    def serve(self, leg: int, served: float, arrival: float,
              until: float) -> Tuple[int, float, float]:
        """Serves the destination of a leg, and the next ones if they are at the same vertex.

        A destination is served only if the vertex is free for the whole stay.

        Returns the next leg, the end of the last stay, and when the robot may leave.
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
    """The drives, with times, with which each possible plan begins."""
    query: PathQuery
    priority: int = 0
    mid_edge: Optional[MidEdgePosition] = None
    """Its position if it stands between two vertices; then `fixed` is empty."""

    def whole(self, plan: Plan) -> Plan:
        """Returns all drives: the fixed drives and the drives of the plan."""
        return [*self.fixed, *plan]
