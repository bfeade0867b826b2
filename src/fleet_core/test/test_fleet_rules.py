"""Each rule of the planner is necessary: if it is switched off, the checker finds a fault."""
from __future__ import annotations

import time
from random import Random

import numpy as np
import pytest
from fleet_builders import AGV, as_files, graph_of
from fleet_cases import Case
from plan_checker import World, faults
from plan_replay import Stuck, replay

from fleet_core.fleet import RobotType
from fleet_core.geometry import exclusions
from fleet_core.planning import outcomes, reservation_table
from fleet_core.planning.agents import PathQuery
from fleet_core.planning.blocking import Blocking
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.precedence import Conflicting, precedence
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import Task
from trajectory_graph import GraphError

SEEDS = range(300)


def _nothing_is_near_anything(patch):
    none = np.zeros(0, dtype=np.int64)
    patch.setattr(exclusions, '_candidates', lambda *_: (none, none))


def _play_is_forgotten(patch):
    patch.setattr(RobotType, 'reach', property(lambda self: self.radius))


def _clearance_is_forgotten(patch):
    patch.setattr(reservation_table, 'Blocking', lambda network, moving, observer, clearance: (
        Blocking(network, moving, observer, 0.0)))


def _who_waits_is_in_no_way(patch):
    patch.setattr(Blocking, 'wait', lambda self, vertex: [])


def _who_has_arrived_is_in_no_way(patch):
    book = ReservationTable.book

    def leaving(self, robot, kind, vertex, plan, mid_edge=None, until=float('inf'), held=0):
        book(self, robot, kind, vertex, plan, mid_edge, plan[-1].end if plan else until, held)
    patch.setattr(ReservationTable, 'book', leaving)


def _a_drive_is_given_back_when_it_begins(patch):
    at = exclusions.Exclusions.at

    def given_back(self, distance):
        conflicts = at(self, distance)
        return conflicts._replace(forward=0.0 * conflicts.forward,
                                  backward=0.0 * conflicts.backward)
    patch.setattr(exclusions.Exclusions, 'at', given_back)


def _the_order_is_not_told(patch):
    patch.setattr(outcomes, 'precedence', lambda *_: [])


def _others_are_let_in_too_early(patch):
    patch.setattr(outcomes, 'precedence', lambda *of: [
        c._replace(fraction=c.fraction / 2.0) for c in precedence(*of)])


def _only_the_first_of_several_is_waited_for(patch):
    def first_only(*of):
        known = set()
        return [c for c in precedence(*of)
                if (c.then, c.drive) not in known and not known.add((c.then, c.drive))]
    patch.setattr(outcomes, 'precedence', first_only)


def _speeds_and_one_ways_are_forgotten(patch):
    patch.setattr(RobotType, 'drives_at', lambda self, edge_speed: self.speed)


def _destinations_are_served_in_any_order(patch):
    begin = PathQuery.__init__

    def sorted_errand(self, network, kind, vertex, origins, ready, destinations, *more):
        begin(self, network, kind, vertex, origins, ready, sorted(destinations), *more)
    patch.setattr(PathQuery, '__init__', sorted_errand)


@pytest.mark.parametrize('switch_off', [
    _nothing_is_near_anything, _play_is_forgotten, _clearance_is_forgotten,
    _who_waits_is_in_no_way, _who_has_arrived_is_in_no_way, _a_drive_is_given_back_when_it_begins,
    _the_order_is_not_told, _others_are_let_in_too_early, _only_the_first_of_several_is_waited_for,
    _speeds_and_one_ways_are_forgotten, _destinations_are_served_in_any_order,
], ids=lambda rule: rule.__name__.strip('_'))
def test_a_rule_that_is_switched_off_is_caught(monkeypatch, switch_off):
    switch_off(monkeypatch)
    assert any(_caught(seed) for seed in SEEDS), 'the checker found no wrong plan'


def _caught(seed: int) -> bool:
    try:
        case = Case(Random(seed))
        plan = case.plan(rounds=0)
    # does not count: the graph is not valid, or the planner itself found the fault
    except (GraphError, Conflicting):
        return False
    return plan is not None and faults(case.world, plan) != []


def _square():
    """Four robots on the corners of a square; each must go to the next corner."""
    corners = {1: (0, 0), 2: (2, 0), 3: (2, 2), 4: (0, 2)}
    graph = graph_of(corners, {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 1)})
    world = World(*as_files(graph, [AGV], {f'r{k}': ('agv', k) for k in corners},
                            {f'r{k}': [k % 4 + 1] for k in corners}, 0.1))
    drives = {f'r{k}': [{'edge': k, 'start': 0.0, 'end': 2.0}] for k in corners}
    return world, {'robots': drives, 'sum_of_costs': 8.0, 'makespan': 2.0, 'lower_bound': 8.0,
                   'precedence': []}


def test_robots_that_follow_each_other_in_a_ring_are_caught():
    """The times fit if all robots move at once, but no order of the drives keeps them safe."""
    world, plan = _square()
    assert any('may come within' in fault for fault in faults(world, plan))
    plan['precedence'] = [[f'r{k % 4 + 1}', 0, 1.0, f'r{k}', 0] for k in range(1, 5)]
    assert 'the precedence has a cycle' in faults(world, plan)
    with pytest.raises(Stuck):
        replay(world, plan, Random(0))


def test_a_ring_without_room_has_no_plan():
    tasks = [Task(f'r{k}', AGV, k, destinations=(k % 4 + 1,), stays=True) for k in range(1, 5)]
    corners = {1: (0, 0), 2: (2, 0), 3: (2, 2), 4: (0, 2)}
    network = RoadNetwork(graph_of(corners, {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 1)}))
    outcome = FleetPlanner(network, 0.1, [AGV]).plan(tasks, (), time.monotonic() + 0.2, 0)
    assert set(outcome.unserved) == {'r1', 'r2', 'r3', 'r4'}
    assert all(drives == () for drives in outcome.drives.values())
