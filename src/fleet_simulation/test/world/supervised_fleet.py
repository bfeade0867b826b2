"""The fleet of the tests: the virtual fleet with plain AGVs, which can lose their link."""
from __future__ import annotations

import math
from typing import Any, Mapping, Tuple

from fleet_core.fleet import RobotType
from fleet_simulation.virtual_fleet import VirtualFleet
from trajectory_graph import Graph
from world.plain_agv import Agv, LostLink


class SupervisedFleet(VirtualFleet[Agv]):
    """The virtual world of the tests, with plain AGVs that can lose their link."""

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[RobotType, int]],
                 **more: Any) -> None:
        super().__init__(graph, robots, lambda _, kind, vertex: Agv(graph, kind, vertex), **more)

    def lose_link(self, name: str, commands_only: bool = False) -> None:
        """Cuts the link between a robot and its computer.

        The robot continues its route, and no node knows where it is. The computer reports the
        route as failed. The robot obeys a stop when the link is back.

        commands_only -- only the link for commands is cut; locations still come by another link
        """
        if name not in self.lost:
            self.lost[name] = LostLink(self.agvs[name], self.now, commands_only)

    def find_link(self, name: str) -> None:
        """Restores the link between a robot and its computer."""
        link = self.lost.pop(name, None)
        if isinstance(link, LostLink):
            link.end()


def blocked(fleet: VirtualFleet, name: str) -> Tuple[Tuple[int, ...], Tuple[int, ...]]:
    """Returns the ids of the vertices and of the edges in a robot's allocation."""
    allocation = fleet.supervisor.robots[name].master.allocation
    vertices = {vertex for vertex in (allocation.vertex,) if vertex is not None}
    edges = {abs(hold.edge) for hold in allocation.holds}
    for area in allocation.areas:
        for x, y in area.line:
            near = [vertex.id for vertex in fleet.graph.vertices.values()
                    if math.hypot(vertex.x - x, vertex.y - y) < 1e-6]
            nearest = fleet.graph.nearest_edge(x, y)
            assert nearest is not None
            vertices.update(near)
            edges.update(() if near else nearest[:1])
    return tuple(sorted(vertices)), tuple(sorted(edges))
