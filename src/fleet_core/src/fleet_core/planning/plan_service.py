"""The planner as a service to the supervisor: it answers requests with plans on its graph.

It keeps only results that depend on the graph. So it rarely has to compute geometry for a request.
The same request gets the same answer, regardless of earlier requests.
"""
from __future__ import annotations

import time
from typing import Dict, FrozenSet, List, NamedTuple, Optional, Tuple, Union

from fleet_core.fleet import Fleet, RobotType
from fleet_core.geometry.site_geometry import Alone, SiteGeometry
from fleet_core.planning.layers import Search
from fleet_core.planning.parking import named_parking
from fleet_core.planning.plan_requests import PlanRequest
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import CannotPlan, Obstacle, PlanningOutcome, Task
from trajectory_graph import Graph

_PLANNERS_KEPT = 4  # number of kept planners, each for other closed edges and learned times


class _Roadmap(NamedTuple):
    """The closed edges and learned times for which a planner is made."""

    closed: FrozenSet[int]
    edge_times: FrozenSet[Tuple[Tuple[str, int], float]]


class PlanService:
    """Plans on one graph for the robot types of one fleet.

    graph  -- the trajectory graph
    fleet  -- robot types, clearance and dock approach; its robots are not used
    search -- the search for one robot's path: `safe_intervals.find_path` or `layers.layered`
    seed   -- for all random choices, if the request has no seed
    """

    def __init__(self, graph: Graph, fleet: Fleet, search: Search = find_path,
                 seed: int = 0) -> None:
        self.graph = graph
        self._fleet = fleet
        self._search = search
        self._seed = seed
        self._open = RoadNetwork(graph, (), fleet.dock_approach)
        self._laden: Tuple[RobotType, ...] = ()
        self._planners: Dict[_Roadmap, FleetPlanner] = {}

    def prepare(self) -> None:
        """Computes in advance what depends only on the graph."""
        self._planner(_Roadmap(frozenset(), frozenset())).prepare()

    def _use(self, alone: Tuple[Alone, ...], laden: Tuple[RobotType, ...]) -> None:
        """Computes again which places exclude each other."""
        dock_approach, self._laden = self._fleet.dock_approach, laden
        self._open = RoadNetwork(self.graph, (), dock_approach,
                                 geometry=SiteGeometry(self.graph, dock_approach, alone))
        self._planners.clear()
        self.prepare()

    def parking_by_name(self) -> FrozenSet[int]:
        """Returns the ids of all vertices at which the graph allows parking.

        Robots parked there may cut off other robots.
        """
        return frozenset(self._open.vertex_ids[vertex] for kind in self._fleet.types
                         for vertex in named_parking(self._open, kind))

    def answer(self, request: PlanRequest, received: Optional[float] = None) -> PlanningOutcome:
        """Returns the plans. Limits count from `received` (monotonic s; default: now).

        Raises CannotPlan for an invalid request.
        """
        begun = time.monotonic() if received is None else received
        self._check(request)
        if (request.alone, request.laden) != (self._open.geometry.alone, self._laden):
            self._use(request.alone, request.laden)
            begun = time.monotonic()  # the time for `_use` does not count
        planner = self._planner(_Roadmap(request.closed, frozenset(request.edge_times.items())))
        planner.parking = tuple(sorted(request.parking))
        return planner.plan(request.tasks, request.obstacles, begun + request.time_limit,
                            improve_until=begun + request.improvement, seed=request.seed,
                            reserved=request.reserved)

    def _check(self, request: PlanRequest) -> None:
        robots: List[Union[Task, Obstacle]] = [*request.tasks, *request.obstacles]
        names = [robot.name for robot in robots]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise CannotPlan(f'Robot {twice} stands in the request twice; name it once.')
        for robot in robots:
            if robot.type not in (*self._fleet.types, *request.laden):
                raise CannotPlan(f'Robot {robot.name}: there is no robot type {robot.type.name}; '
                                 'describe it in the fleet file.')
        for obstacle in request.obstacles:
            self._check_ids(f'Robot {obstacle.name}', obstacle.vertices, obstacle.edges)
        self._check_ids('Parking', (*request.parking, *request.reserved), ())
        for alone in request.alone:
            self._check_ids('A resource', tuple(alone.vertices), tuple(alone.edges))
        for (kind, edge), seconds in request.edge_times.items():
            if not 0.0 < seconds < 1e6:
                raise CannotPlan(f'The learned time of {kind} on edge {edge} is {seconds} s, but '
                                 'must be above 0 and below 1e6 s; omit it.')

    def _check_ids(self, asker: str, vertices: Tuple[int, ...], edges: Tuple[int, ...]) -> None:
        for id in vertices:
            if id not in self.graph.vertices:
                raise CannotPlan(f'{asker}: the graph has no vertex {id}; choose another.')
        for id in edges:
            if abs(id) not in self.graph.edges:
                raise CannotPlan(f'{asker}: the graph has no edge {id}; choose another.')

    def _planner(self, roadmap: _Roadmap) -> FleetPlanner:
        """Returns the planner for these closed edges and times: a kept planner, or a new one."""
        planner = self._planners.pop(roadmap, None)
        if planner is None:
            network = self._open.with_closed(roadmap.closed, dict(roadmap.edge_times))
            planner = FleetPlanner(network, self._fleet.clearance,
                                   (*self._fleet.types, *self._laden),
                                   search=self._search, seed=self._seed)
            while len(self._planners) >= _PLANNERS_KEPT:
                del self._planners[next(iter(self._planners))]
        self._planners[roadmap] = planner
        return planner
