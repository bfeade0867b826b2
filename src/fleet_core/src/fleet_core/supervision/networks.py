"""The graph as robots can drive it now: closed edges, and learned driving times."""
from __future__ import annotations

from functools import lru_cache
from math import inf
from typing import Iterable, Sequence

from fleet_core.fleet import Fleet, RobotType
from fleet_core.geometry.site_geometry import Alone, SiteGeometry
from fleet_core.interlocking.resources import Resource
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.edge_times import EdgeTimes
from fleet_core.supervision.robots import ManagedRobot
from trajectory_graph import Graph, speed_of


class Networks:
    """One network with nominal times, and one with learned times.

    rate      -- the factor by which simulated robots are faster than the clock
    resources -- if only one robot may use a resource, its places exclude each other in plans
    laden     -- types of robots with loads, in addition to the types of the fleet
    """

    def __init__(self, graph: Graph, fleet: Fleet, rate: float = 1.0,
                 resources: Sequence[Resource] = (),
                 laden: Sequence[RobotType] = ()) -> None:
        self.geometry = SiteGeometry(graph, fleet.dock_approach)
        """The geometry for the interlocking, without the exclusions that resources add to plans."""
        alone = [Alone(one.edges, one.vertices) for one in resources if one.orders_plans]
        self.nominal = RoadNetwork(
            graph, (), fleet.dock_approach,
            geometry=SiteGeometry(graph, fleet.dock_approach, alone) if alone else self.geometry)
        self.network = self.nominal
        """The network with learned times."""
        # cached, because each view of the fleet needs these times for each drive of each plan
        self.edge_times = EdgeTimes(lru_cache(maxsize=None)(self._nominal_time))
        self._types = {kind.name: kind for kind in (*fleet.types, *laden)}
        self._rate = rate

    def close(self, edges: Iterable[int]) -> bool:
        """Closes exactly these edges, if the graph has them. Returns whether anything has changed.
        """
        graph = self.nominal.graph
        closed = frozenset(abs(edge) for edge in edges) & frozenset(graph.edges)
        if closed == self.nominal.closed:
            return False
        self.nominal = self.nominal.with_closed(closed)
        self._renew()
        return True

    def learn(self, robot: ManagedRobot, now: float) -> None:
        """Learns from the edges that a robot has driven. The next plan uses the new times."""
        for driven in robot.driven:
            self.edge_times.learn(robot.type.name, driven._replace(
                seconds=driven.seconds * self._rate))
        robot.driven.clear()
        if self.edge_times.renew(now):
            self._renew()

    def _renew(self) -> None:
        self.network = self.nominal.with_closed(self.nominal.closed, self.edge_times.table)

    def _nominal_time(self, kind: str, edge: int) -> float:
        graph = self.nominal.graph
        speed = self._types[kind].drives_at(speed_of(graph, edge))
        return graph.curve(edge).length / speed if speed else inf
