"""The fleet of the tests: the virtual fleet with plain AGVs, which can lose their link."""
from __future__ import annotations

import math
from typing import Any, Callable, List, Mapping, Tuple

from fleet_core.fleet import RobotType
from fleet_core.supervision.missions import MissionState, Request
from fleet_simulation.virtual_fleet import STEP, VirtualFleet
from trajectory_graph import Graph
from world.plain_agv import Agv, LostLink


class SupervisedFleet(VirtualFleet[Agv]):
    """The virtual world of the tests, with plain AGVs that can lose their link."""

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[RobotType, int]],
                 **more: Any) -> None:
        super().__init__(graph, robots, lambda _, kind, vertex: Agv(graph, kind, vertex), **more)

    def lose_link(self, name: str, commands_only: bool = False) -> None:
        """Cuts the link between a robot and its computer.

        The robot continues its route, but no node knows its place. The computer reports the route
        as failed. The robot obeys a stop when the link is back.

        commands_only -- only the link for commands is cut; another link still carries locations
        """
        if name not in self.lost:
            self.lost[name] = LostLink(self.agvs[name], self.now, commands_only)

    def find_link(self, name: str) -> None:
        """Restores the link between a robot and its computer."""
        link = self.lost.pop(name, None)
        if isinstance(link, LostLink):
            link.end()

    # -- actions of users, and queries ------------------------------------------------------------

    def request(self, id: int, *destinations: int, **more: Any) -> None:
        """Sends a mission."""
        self.do(self.supervisor.request(Request(id, destinations, **more), self.now))

    def close(self, *edges: int) -> None:
        """Closes these edges, and opens all others."""
        self.closed = edges
        self.do(self.supervisor.close_edges(edges, self.now))

    def bring_in(self, name: str) -> str:
        """Brings a robot into service, as a person does; returns the problem, or an empty text.

        If the robot must stop before that, this method tries once more 3 s later.
        """
        for _ in range(2):
            problem, actions = self.supervisor.bring_in(name, self.now)
            self.do(actions)
            if not (problem and self.supervisor.robots[name].master.is_stopping):
                break
            self.run(3.0)
        return problem

    def state(self, id: int) -> MissionState:
        """Returns the state of a mission."""
        mission = self.supervisor.book.find(id)
        assert mission is not None, f'mission {id} is not known'
        return mission.state

    def told(self, id: int) -> List[MissionState]:
        """Returns the published states of a mission in order, without immediate repetitions."""
        states = [status.state for status in self.statuses if status.request_id == id]
        return [s for k, s in enumerate(states) if k == 0 or states[k - 1] != s]

    def robot_of(self, id: int) -> str:
        """Returns the name of the robot to which a mission was last assigned."""
        mission = self.supervisor.book.find(id)
        assert mission is not None
        return mission.robot

    def reached(self, id: int) -> int:
        """Returns the number of visited destinations of a mission."""
        mission = self.supervisor.book.find(id)
        assert mission is not None
        return mission.reached

    # -- time -------------------------------------------------------------------------------------

    def run(self, seconds: float) -> None:
        """Simulates the given virtual time, in s."""
        for _ in range(round(seconds / STEP)):
            self.step()

    def run_until(self, condition: Callable[[], bool], limit: float = 300.0) -> None:
        """Simulates until the condition holds; fails after `limit` virtual s."""
        begun = self.now
        while not condition():
            assert self.now - begun < limit, self.picture()
            self.step()

    def run_until_done(self, *ids: int, limit: float = 600.0) -> float:
        """Simulates until these missions have ended; returns the virtual time, in s.

        Fails after `limit` virtual s.
        """
        begun = self.now
        while any(self.state(id).is_open for id in ids):
            assert self.now - begun < limit, self.picture()
            self.step()
        return self.now - begun


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
