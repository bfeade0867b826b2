"""Robots that stand between two vertices hold the point where they are, not their whole edge."""
from __future__ import annotations

import pytest
from fleet_builders import AGV, corridor

from graph_fleet_manager.planning.planner import FleetPlanner
from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.planning.tasks import Task


@pytest.mark.parametrize('names', [('a', 'b'), ('b', 'a')])
def test_a_robot_far_enough_from_one_between_vertices_is_planned(names):
    planner = FleetPlanner(RoadNetwork(corridor(4)), 0.1, [AGV], (1, 2, 3, 4))
    outcome = planner.plan([Task(names[0], AGV, 2, destinations=(1,)),
                            Task(names[1], AGV, mid_edge=(2, 0.5), destinations=(4,))], rounds=0)
    assert outcome.unserved == {}


@pytest.mark.parametrize('names', [('a', 'b'), ('b', 'a')])
def test_a_robot_too_near_to_one_between_vertices_is_told_so(names):
    planner = FleetPlanner(RoadNetwork(corridor(4)), 0.1, [AGV], (1, 2, 3, 4))
    outcome = planner.plan([Task(names[0], AGV, 2, destinations=(1,)),
                            Task(names[1], AGV, mid_edge=(2, 0.4), destinations=(4,))], rounds=0)
    assert set(outcome.unserved) == {'a', 'b'}


def test_a_robot_between_vertices_may_go_on_while_another_comes_to_the_vertex_behind_it():
    planner = FleetPlanner(RoadNetwork(corridor(4)), 0.1, [AGV], (1, 2, 3, 4))
    outcome = planner.plan([Task('a', AGV, mid_edge=(2, 0.55), destinations=(4,)),
                            Task('b', AGV, released=(1,), destinations=(2,))], rounds=0)
    assert outcome.unserved == {}
    assert outcome.drives['a'][0].start == 0.0, 'what lies behind it is not its business'
