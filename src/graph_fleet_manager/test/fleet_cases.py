"""Random instances for the planner, each drawn from a seed, and their plans as files."""
from __future__ import annotations

import math
import time
from random import Random

from fleet_builders import as_files, random_graph
from plan_checker import World

from graph_fleet_manager.files.plan_file import solved_plan
from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.planning.planner import FleetPlanner
from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.planning.safe_intervals import find_path
from graph_fleet_manager.planning.tasks import Task

GIVE_UP = 0.3  # s after which an instance counts as one without a solution


class Case:
    """A random graph with a random fleet on it."""

    def __init__(self, random: Random) -> None:
        self.graph = random_graph(random, random.randint(4, 14), random.randint(0, 8),
                                  random.choice((1.2, 2.0, 3.0)))
        self.clearance = random.choice((0.0, 0.1))
        self.types = [RobotType('small', random.uniform(0.1, 0.3), random.uniform(0.4, 1.5)),
                      RobotType('large', random.uniform(0.3, 0.6), 1.0, random.choice((0.0, 0.1)),
                                random.random() < 0.7)]
        self.network = RoadNetwork(self.graph)
        self.robots = {}
        self.missions = {}
        ends = []
        for k in range(random.randint(2, 6)):
            kind = random.choice(self.types)
            starts = [(r.type, r.vertex) for r in self.robots.values()]
            vertex = self._free(random, kind, starts)
            if vertex is None:
                break
            name = f'r{k}'
            self.robots[name] = Task(name, kind, vertex, stays=True)
            stops = [random.choice(list(self.graph.vertices))
                     for _ in range(random.choice((0, 0, 1, 2)))]
            last = self._free(random, kind, ends)
            if last is not None and random.random() < 0.8 and self._reaches(
                    kind, (vertex, *stops, last)):
                ends.append((kind, last))
                self.missions[name] = (*stops, last)

    def _free(self, random, kind, taken):
        places = {v.id: v.position for v in self.graph.vertices.values()}
        free = [id for id in places if all(
            math.dist(places[id], places[other]) >= kind.reach + t.reach + self.clearance
            for t, other in taken)]
        return random.choice(free) if free else None

    def _reaches(self, kind, stops):
        return all(math.isfinite(self.network.paths_to(kind, (self.network.index[b],))[0][
            self.network.index[a]]) for a, b in zip(stops, stops[1:]))

    def plan(self, search=find_path, seed=0, rounds=10):
        """The plan as it stands in the file, None where none was found."""
        planner = FleetPlanner(self.network, self.clearance, self.types, search=search, seed=seed)
        tasks = [Task(t.name, t.type, t.vertex, destinations=self.missions.get(t.name, ()),
                      stays=True) for t in self.robots.values()]
        outcome = planner.plan(tasks, (), time.monotonic() + GIVE_UP, rounds)
        return None if outcome.unserved else solved_plan(outcome, 0.0, 0.0)

    @property
    def world(self):
        """For the checker."""
        return World(*as_files(self.graph, self.types, {
            name: (t.type.name, t.vertex) for name, t in self.robots.items()},
            self.missions, self.clearance))
