"""Robots between two vertices block the point where they are, not their whole edge.

They are planned like all other robots, also out of an edge that is closed meanwhile, and out of any
tangle of robots.
"""
from __future__ import annotations

import os
from random import Random

import pytest
from fleet_builders import AGV, corridor, graph_of
from fleet_cases import MidEdgeCase
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from plan_checker import faults
from plan_replay import replay, replay_faults

from fleet_core.files.plan_file import solved_plan
from fleet_core.geometry.areas import Area
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import Obstacle, PlannedDrive, Task
from trajectory_graph import GraphError

LONG = os.environ.get('LD90_LONG_TESTS') == '1'


def planner(graph, closed=()):
    return FleetPlanner(RoadNetwork(graph, closed), 0.1, [AGV], graph.vertices)


def edges(outcome, robot):
    return [drive.edge for drive in outcome.drives[robot]]


@pytest.mark.parametrize('names', [('a', 'b'), ('b', 'a')])
def test_a_robot_far_enough_from_one_between_vertices_is_planned(names):
    outcome = planner(corridor(4)).plan(
        [Task(names[0], AGV, 2, destinations=(1,)),
         Task(names[1], AGV, mid_edge=(2, 0.5), destinations=(4,))], rounds=0)
    assert outcome.unserved == {}


@pytest.mark.parametrize('names', [('a', 'b'), ('b', 'a')])
def test_a_robot_too_near_to_one_between_vertices_is_told_so(names):
    outcome = planner(corridor(4)).plan(
        [Task(names[0], AGV, 2, destinations=(1,)),
         Task(names[1], AGV, mid_edge=(2, 0.4), destinations=(4,))], rounds=0)
    assert set(outcome.unserved) == {'a', 'b'}


def test_a_robot_between_vertices_may_go_on_while_another_comes_to_the_vertex_behind_it():
    outcome = planner(corridor(4)).plan([Task('a', AGV, mid_edge=(2, 0.55), destinations=(4,)),
                                         Task('b', AGV, released=(1,), destinations=(2,))],
                                        rounds=0)
    assert outcome.unserved == {}
    assert outcome.drives['a'][0].start == 0.0, 'the robot must not block places behind it'


@pytest.mark.parametrize('gap, too_near', [(0.4, False), (0.1, True)])
def test_two_robots_on_one_edge_leave_it_apart_if_their_points_are_far_enough_apart(gap, too_near):
    outcome = planner(corridor(4, spacing=5.0)).plan(
        [Task('a', AGV, mid_edge=(2, 0.5 - gap / 2), destinations=(1,), stays=True),
         Task('b', AGV, mid_edge=(2, 0.5 + gap / 2), destinations=(4,), stays=True)], rounds=0)
    assert set(outcome.unserved) == ({'a', 'b'} if too_near else set())
    if not too_near:
        assert (edges(outcome, 'a'), edges(outcome, 'b')) == ([-2, -1], [2, 3])


@pytest.mark.parametrize('goal, way', [(1, [-2, -1]), (4, [2, 3])])
def test_a_robot_leaves_a_closed_edge_to_either_side(goal, way):
    outcome = planner(corridor(4), closed=(2,)).plan(
        [Task('a', AGV, mid_edge=(2, 0.25), destinations=(goal,), stays=True)], rounds=0)
    assert outcome.unserved == {}
    assert edges(outcome, 'a') == way


def test_a_robot_leaves_a_closed_edge_only_in_the_direction_that_the_edge_allows():
    graph = graph_of({1: (0, 0), 2: (4, 0), 3: (4, 4)}, {1: (1, 2), 2: (2, 3), 3: (3, 1)},
                     one_way=(1,))
    task = Task('a', AGV, mid_edge=(1, 0.1), destinations=(1,), stays=True)
    assert edges(planner(graph, closed=(1,)).plan([task], rounds=0), 'a') == [1, 2, 3]


def test_a_robot_does_not_come_back_to_a_closed_edge_that_it_has_left():
    outcome = planner(corridor(4), closed=(2,)).plan(
        [Task('a', AGV, mid_edge=(2, 0.25), destinations=(1, 4), stays=True)], rounds=0)
    assert 'vertex 4 cannot be reached from vertex 1 while edges 2 are closed' in \
        outcome.unserved['a']


def test_a_robot_keeps_its_plan_out_of_an_edge_that_was_closed():
    kept = (PlannedDrive(-2, 0.0, 0.5), PlannedDrive(-1, 0.5, 2.5))
    outcome = planner(corridor(4), closed=(2,)).plan(
        [Task('a', AGV, mid_edge=(2, 0.25), destinations=(1,), stays=True, kept=kept)], rounds=0)
    assert edges(outcome, 'a') == [-2, -1]


def test_an_obstacle_blocks_the_rest_of_an_edge_but_not_the_part_behind():
    graph = corridor(3, spacing=8.0)
    for centre, is_blocked in ((4.0, False), (12.0, True)):
        beside = Obstacle('dead', AGV, areas=(Area(((centre, 0.5),), 0.1),))
        outcome = planner(graph).plan(
            [Task('a', AGV, mid_edge=(2, 0.1), destinations=(3,), stays=True)], [beside], rounds=0)
        assert ('a' in outcome.unserved) is is_blocked
        assert not is_blocked or 'dead, which cannot move' in outcome.unserved['a']


def test_robots_between_vertices_find_out_of_a_tangle_like_others():
    """Not slower than the same robots on the vertices behind them; fixed instances."""
    solved = {True: 0, False: 0}
    for seed in range(200 if LONG else 30):
        try:
            case = MidEdgeCase(Random(seed))
        except GraphError:
            continue
        for mid_edge in solved:
            solved[mid_edge] += not case.outcome(mid_edge).unserved
    assert solved[True] >= solved[False] > 5


@settings(max_examples=1000 if LONG else settings.default.max_examples * 2 // 5,
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
