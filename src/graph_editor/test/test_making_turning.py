"""Lanes are moved to places where robots can turn, and new lanes lead to rooms without lanes."""
from __future__ import annotations

from typing import Tuple

import numpy as np
import pytest
from floor_plans import Plan

from graph_editor.making.coverage import Coverage
from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.making.reaching import reach_out
from graph_editor.making.straights import margins_of
from graph_editor.making.tidying import tidy
from graph_editor.making.tips import give_tips_room
from graph_editor.making.widening import widen

OPTIONS = MakingOptions()


def net_of(plan: Plan, *nodes: Tuple[float, float], need: float = OPTIONS.tight) -> LaneNet:
    """Returns nodes with ids from 1, and a lane from each node to the next."""
    net = LaneNet(plan.site().floor)
    places = np.array(nodes)
    ids = [net.add_node(place) for place in places]
    for k, (a, b) in enumerate(zip(ids, ids[1:])):
        net.add_lane(a, b, need, places[k:k + 2])
    return net


def room_at(net: LaneNet, node: int) -> float:
    return float(net.floor.clearance_at(net.positions[node][None, :])[0])


def passage(door: float = 0.7) -> Plan:
    """Returns a corridor below, a room above, and a door between them at the right."""
    return Plan(5.3, 5.0, ((0.0, 1.75, 4.0, 1.85), (4.0 + door, 1.75, 5.3, 1.85)), (0.9, 0.9))


def test_to_a_room_without_lanes_one_leads_from_the_lanes_that_there_are():
    net = net_of(passage(), (0.6, 0.9), (4.0, 0.9))
    reach_out(net, OPTIONS)
    assert len(list(net.components())) == 1
    assert max(net.positions[node][1] for node in net.nodes) > 2.5
    assert min(map(net.clearance, net.lanes)) >= OPTIONS.tight - 1e-6
    assert min(room_at(net, node) for node in net.nodes) >= OPTIONS.least_turning


@pytest.mark.parametrize('plan, why', [
    (passage(door=0.5), 'robots do not fit through'),
    (Plan(5.3, 1.8, (), (0.9, 0.9)), 'no floor is far from the lane')])
def test_no_lane_leads_where_none_can_or_need(plan, why):
    net = net_of(plan, (0.6, 0.9), (4.7, 0.9))
    reach_out(net, OPTIONS)
    assert len(net.lanes) == 1, why


def test_a_dead_end_that_is_moved_aside_keeps_the_clearance_that_a_lane_needs():
    narrow = Plan(2.6, 5.5, ((0.0, 2.0, 1.0, 3.5), (1.55, 2.0, 2.6, 3.5)), (1.3, 1.0))
    net = net_of(narrow, (1.235, 1.4), (1.325, 3.6))
    coverage = Coverage(net.floor, net.floor.clearance >= OPTIONS.robot_width / 2.0, OPTIONS.reach)
    give_tips_room(net, coverage, OPTIONS, (), ())
    lane, = net.lanes
    assert net.clearance(lane) >= margins_of(OPTIONS)[-1].straight - 1e-6
    assert max(net.positions[node][1] for node in net.nodes) > 3.6, (
        'the dead end must reach behind the passage')


def test_two_bends_do_not_become_one_where_robots_cannot_turn():
    """Because of objects, one bend cannot be merged into the other. The extended outer lanes meet
    near an object.
    """
    things = (1.95, 3.6, 2.0, 3.65), (2.4, 4.0, 2.45, 4.05), (3.2, 2.65, 3.3, 2.75)
    bends = (1.0, 3.0), (2.6, 3.0), (3.0, 3.4), (3.0, 5.0)
    for turning, lanes in ((0.0, 2), (OPTIONS.least_turning, 3)):
        net = net_of(Plan(6.0, 6.0, things, (1.0, 1.0)), *bends, need=0.5)
        net.with_need(net.lane(2, 3), OPTIONS.tight)
        tidy(net, turning=turning)
        assert len(net.lanes) == lanes
    assert min(room_at(net, node) for node in net.nodes) >= OPTIONS.least_turning


def test_of_two_parts_the_one_stays_that_robots_can_drive_to_not_the_nearer_one():
    """Robots fit through the gap between the two parts, but they cannot turn in front of this gap.
    """
    block = (2.0, 0.6, 3.2, 1.8)
    plan = Plan(8.0, 5.0, ((0.0, 1.7, 1.15, 1.8), (1.85, 1.7, 8.0, 1.8), block), (0.9, 0.85))
    net = net_of(plan, (1.5, 4.3), (1.5, 0.3), (3.7, 0.3), (7.0, 0.3))
    gap, = widen(net, OPTIONS, {}, [plan.start])
    assert net.nodes == [1]
    assert 'm of lanes behind it' in gap.note(())
