"""A checker that shares no code with the planner judges every plan and every answer.

For answers of the plan service, the fleets have robots that are out of service, closed edges and
kept plans.
"""
from __future__ import annotations

from dataclasses import replace
from random import Random

import pytest
from fleet_builders import as_files
from fleet_cases import Case, MidEdgeCase
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from plan_checker import World, faults
from plan_replay import replay, replay_faults
from proofs import LONG, is_whole

from fleet_core.files.plan_file import solved_plan
from fleet_core.fleet import Fleet
from fleet_core.planning.layers import layered
from fleet_core.planning.plan_requests import PlanRequest
from fleet_core.planning.plan_service import PlanService
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import Obstacle
from trajectory_graph import GraphError

# -- plans -----------------------------------------------------------------------------------------

WHOLE = is_whole(__file__)
EXAMPLES = max(2, settings.default.max_examples * 2 // (5 if WHOLE else 15))


@pytest.mark.parametrize('search', [find_path, layered(0.5)], ids=['safe_intervals', 'layers'])
@settings(max_examples=2000 if LONG else EXAMPLES,
          suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2 ** 32 - 1))
def test_a_plan_on_any_graph_is_safe_whatever_the_delays(search, seed):
    random = Random(seed)
    try:
        case = Case(random)
    except GraphError:
        assume(False)
    plan = case.plan(search, seed)
    assume(plan is not None)
    world = case.world
    assert faults(world, plan) == []
    for _ in range(3):
        assert replay_faults(world, plan, replay(world, plan, random)) == []


def test_many_drives_under_random_delays_come_near_nobody():
    """The number of drives is limited; with LD90_LONG_TESTS=1 it is a million."""
    driven, seed = 0, 0
    while driven < (1_000_000 if LONG else 2_000 if WHOLE else 500):
        seed += 1
        random = Random(seed)
        try:
            case = Case(random)
        except GraphError:
            continue
        plan = case.plan(rounds=0)
        if plan is None:
            continue
        world = case.world
        for _ in range(50 if LONG else 5):
            drives = replay(world, plan, random)
            assert replay_faults(world, plan, drives) == [], seed
            driven += sum(map(len, drives.values()))


# -- robots between two vertices ------------------------------------------------------------------

def test_robots_between_vertices_find_out_of_a_tangle_like_others():
    """A plan is found for at least as many instances as if these robots stood on vertices."""
    solved = {True: 0, False: 0}
    for seed in range(200 if LONG else 30 if WHOLE else 20):
        try:
            case = MidEdgeCase(Random(seed))
        except GraphError:
            continue
        for mid_edge in solved:
            solved[mid_edge] += not case.outcome(mid_edge).unserved
    assert solved[True] >= solved[False] > 5


@settings(max_examples=1000 if LONG else EXAMPLES,
          suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2 ** 32 - 1))
def test_plans_of_robots_between_vertices_are_safe_whatever_the_delays(seed):
    random = Random(seed)
    try:
        case = MidEdgeCase(random)
    except GraphError:
        assume(False)
    assume(case.moved)
    outcome = case.outcome(mid_edge=True, rounds=random.choice((0, 10)))
    world, plan = case.world, solved_plan(outcome, 0.0, 0.0)
    for name in outcome.unserved:
        world.missions.pop(name, None)
    assert faults(world, plan) == []
    for _ in range(3):
        assert replay_faults(world, plan, replay(world, plan, random)) == []


# -- answers to requests of a running fleet --------------------------------------------------------


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
        """The faults that the checker finds. It assumes that the robot out of service stands."""
        plan = solved_plan(outcome, 0.0, 0.0)
        plan['robots'][self.out] = []
        missions = {task.name: task.destinations for task in tasks
                    if task.destinations and task.name not in outcome.unserved}
        world = World(*as_files(self.case.graph, self.case.types, {
            name: (task.type.name, task.vertex) for name, task in self.case.robots.items()},
            missions, self.case.clearance))
        return faults(world, plan)


def running_fleet(seed):
    """A random fleet, and its source of random numbers; skips examples without a valid graph."""
    random = Random(seed)
    try:
        return random, RunningFleet(random)
    except GraphError:
        return assume(False)


@settings(max_examples=1000 if LONG else EXAMPLES,
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


@settings(max_examples=500 if LONG else EXAMPLES // 2,
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
