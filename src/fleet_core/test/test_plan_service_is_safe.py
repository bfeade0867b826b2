"""Answers to requests of a running fleet, judged by an independent checker.

The fleet has robots that are out of service, closed edges and kept plans. The checker shares no
code with the planner.
"""
from __future__ import annotations

import os
from dataclasses import replace
from random import Random

from fleet_builders import as_files
from fleet_cases import Case
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from plan_checker import World, faults

from fleet_core.files.plan_file import solved_plan
from fleet_core.fleet import Fleet
from fleet_core.planning.plan_requests import PlanRequest
from fleet_core.planning.plan_service import PlanService
from fleet_core.planning.tasks import Obstacle
from trajectory_graph import GraphError

LONG = os.environ.get('LD90_LONG_TESTS') == '1'


class RunningFleet:
    """A random fleet with one robot out of service where it stands, and some closed edges."""

    def __init__(self, random: Random) -> None:
        self.case = Case(random)
        names = list(self.case.robots)
        self.out = random.choice(names)
        dead = self.case.robots[self.out]
        self.obstacle = Obstacle(self.out, dead.type, (dead.vertex,))
        edges = list(self.case.graph.edges)
        self.closed = frozenset(random.sample(edges, random.randint(0, len(edges) // 4)))
        self.service = PlanService(self.case.graph, Fleet(tuple(self.case.types), (),
                                                          self.case.clearance))
        self.tasks = tuple(replace(task, destinations=self.case.missions.get(name, ()))
                           for name, task in self.case.robots.items() if name != self.out)

    def answer(self, tasks):
        return self.service.answer(PlanRequest(tasks, (self.obstacle,), self.closed,
                                               time_limit=0.3, improvement=0.05))

    def faults(self, tasks, outcome):
        """The checker's findings; the robot that is out of service counts as one that drives
        nowhere.
        """
        plan = solved_plan(outcome, 0.0, 0.0)
        plan['robots'][self.out] = []
        missions = {task.name: task.destinations for task in tasks
                    if task.destinations and task.name not in outcome.unserved}
        world = World(*as_files(self.case.graph, self.case.types, {
            name: (task.type.name, task.vertex) for name, task in self.case.robots.items()},
            missions, self.case.clearance))
        return faults(world, plan)


def running_fleet(seed):
    """A random fleet, and random decisions; an example without a valid graph is skipped."""
    random = Random(seed)
    try:
        return random, RunningFleet(random)
    except GraphError:
        return assume(False)


@settings(max_examples=1000 if LONG else settings.default.max_examples * 2 // 5,
          suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2 ** 32 - 1))
def test_every_answer_is_safe_and_drives_no_closed_edge(seed):
    random, fleet = running_fleet(seed)
    first = fleet.answer(fleet.tasks)
    assert fleet.faults(fleet.tasks, first) == []

    # One robot gets another destination; all others keep the plans of the first answer.
    changed = random.randrange(len(fleet.tasks)) if fleet.tasks else 0
    vertices = list(fleet.case.graph.vertices)
    tasks = tuple(replace(task, destinations=(random.choice(vertices),) if k == changed
                          else task.destinations, kept=first.drives[task.name])
                  for k, task in enumerate(fleet.tasks))
    second = fleet.answer(tasks)
    assert fleet.faults(tasks, second) == []

    for outcome in (first, second):
        driven = {abs(drive.edge) for drives in outcome.drives.values() for drive in drives}
        assert not driven & fleet.closed
        assert set(outcome.drives) == {task.name for task in fleet.tasks}


@settings(max_examples=500 if LONG else settings.default.max_examples // 5,
          suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2 ** 32 - 1))
def test_who_is_blocked_keeps_the_plan_that_it_owns(seed):
    _, fleet = running_fleet(seed)
    first = fleet.answer(fleet.tasks)
    owners = [task for task in fleet.tasks if task.name not in first.unserved]
    assume(owners)
    here = fleet.obstacle.vertices  # no robot can reach this vertex
    tasks = tuple(replace(task, destinations=here if task is owners[0] else task.destinations,
                          kept=first.drives[task.name]) for task in fleet.tasks)
    second = fleet.answer(tasks)
    assume('cannot be reached' not in second.unserved.get(owners[0].name, ''))
    assert owners[0].name in second.unserved
    assert [drive.edge for drive in second.drives[owners[0].name]] == [
        drive.edge for drive in first.drives[owners[0].name]]
