"""Random instances for the planner, each made from a seed, and their plans as in plan files."""
from __future__ import annotations

import math
import time
from dataclasses import replace
from random import Random
from unittest.mock import patch

from fleet_builders import as_files, random_graph
from plan_checker import World

from fleet_core.files.plan_file import solved_plan
from fleet_core.fleet import RobotType
from fleet_core.planning import safe_intervals
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import Task

GIVE_UP = 0.3  # s of CPU time after which an instance counts as having no solution


def plan_in_time(planner, tasks, rounds):
    """Plans with a limit on CPU time, so that other load on the computer does not matter."""
    with patch('time.monotonic', time.process_time), \
            patch.object(safe_intervals, 'time_now', time.process_time):
        return planner.plan(tasks, (), time.process_time() + GIVE_UP, rounds)


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
        """The plan in the form of the plan file; None: no plan was found."""
        planner = FleetPlanner(self.network, self.clearance, self.types, search=search, seed=seed)
        tasks = [Task(t.name, t.type, t.vertex, destinations=self.missions.get(t.name, ()),
                      stays=True) for t in self.robots.values()]
        outcome = plan_in_time(planner, tasks, rounds)
        return None if outcome.unserved else solved_plan(outcome, 0.0, 0.0)

    @property
    def world(self):
        """The instance for the checker."""
        world = World(*as_files(self.graph, self.types, {
            name: (t.type.name, t.vertex) for name, t in self.robots.items()},
            self.missions, self.clearance))
        for name, task in self.robots.items():
            if task.mid_edge:
                world.robots[name].update(edge=task.mid_edge[0], fraction=task.mid_edge[1])
                del world.robots[name]['vertex']
        return world


class MidEdgeCase(Case):
    """A random fleet in which some robots, `moved`, stand between the ends of an edge.

    In a `Case` with the same random numbers, these robots stand at the first end of their edge.
    Some of these edges are closed.
    """

    def __init__(self, random: Random, share: float = 0.5) -> None:
        super().__init__(random)
        self.moved = []
        self.closed = frozenset()
        for name, task in self.robots.items():
            ways = [(edge, sign) for edge in self.graph.edges.values() for sign in (1, -1)
                    if task.vertex == (edge.origin, edge.destination)[sign < 0]]
            if not ways or random.random() > share:
                continue
            edge, sign = random.choice(ways)
            fraction = random.uniform(0.02, 0.98)
            back = task.type.drives_at((edge.velocity_backwards, edge.velocity_forward)[sign < 0])
            if back and all(self._distance(one, (sign * edge.id, fraction)) > (
                    one.type.reach + task.type.reach + self.clearance)
                    for one in self.robots.values() if one is not task):
                self.robots[name] = replace(task, vertex=None, mid_edge=(sign * edge.id, fraction))
                self.moved.append(name)
        own = sorted({abs(self.robots[name].mid_edge[0]) for name in self.moved})
        closed = [edge for edge in own if random.random() < 0.3]
        self.closed = frozenset(closed)

    def _distance(self, robot, mid_edge):
        return math.dist(self._point(robot.mid_edge) if robot.mid_edge else
                         self.graph.vertices[robot.vertex].position, self._point(mid_edge))

    def _point(self, mid_edge):
        curve = self.graph.curve(mid_edge[0])
        return curve.point_at(mid_edge[1] * curve.length)

    def outcome(self, mid_edge, rounds=0):
        """Plans the case. Returns the outcome.

        mid_edge -- False: robots between two vertices are put on the first end of their edge
        """
        tasks = [replace(task, destinations=self.missions.get(name, ()), stays=True,
                         **({} if mid_edge or not task.mid_edge else {
                             'mid_edge': None, 'vertex': self._vertex(task)}))
                 for name, task in self.robots.items()]
        network = self.network.with_closed(self.closed)
        return plan_in_time(FleetPlanner(network, self.clearance, self.types), tasks, rounds)

    def _vertex(self, task):
        edge = self.graph.edges[abs(task.mid_edge[0])]
        return edge.origin if task.mid_edge[0] > 0 else edge.destination
