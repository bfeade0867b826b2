"""Bends of lanes are round if there is room. No bend is in a narrow door."""
from __future__ import annotations

from typing import List, Sequence, Tuple

import numpy as np
import pytest
from floor_plans import Plan

from graph_editor.making.bends import Piece, ways_of
from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from trajectory_graph.curves import cubic_bezier

OPTIONS = MakingOptions()
CORNERS = ((4.2, 1.0), (4.2, 5.0), (5.8, 5.0), (5.8, 9.0))
"""The corners of a lane (m): up, to the right through a wall at x = 5, and up again."""


def pieces(door: float, corners: Sequence[Tuple[float, float]] = CORNERS) -> List[Piece]:
    """Returns the pieces of a lane along `corners`, which leads through a door between two rooms.

    door -- width of the door, m
    """
    plan = Plan(10.0, 10.0, ((4.95, 0.0, 5.05, 5.0 - door / 2.0),
                             (4.95, 5.0 + door / 2.0, 5.05, 10.0)), (1.0, 1.0))
    net = LaneNet(plan.site().floor)
    nodes = [net.add_node(np.array(corner)) for corner in corners]
    for a, b in zip(nodes, nodes[1:]):
        net.add_lane(a, b, OPTIONS.tight, np.array((net.positions[a], net.positions[b])))
    way, = ways_of(net, (), OPTIONS)
    return list(way.pieces)


def room(piece: Piece, net_floor) -> float:
    """Returns the least clearance (m) along a bend."""
    return float(net_floor.clearance_at(cubic_bezier(piece.control).sample(0.02)).min())


@pytest.mark.parametrize('door', [0.65, 0.8])
def test_a_narrow_door_is_driven_straight_through(door):
    made = pieces(door)
    through, = (piece for piece in made if piece.start[0] < 5.0 < piece.end[0])
    assert through.control is None, 'no bend reaches into the door'
    assert abs(through.end[0] - 5.0) > 0.25, 'no vertex is in the door'
    assert abs(through.start[0] - 5.0) > 0.25, 'no vertex is in the door'


def test_before_and_behind_a_narrow_door_robots_can_turn():
    floor = Plan(10.0, 10.0, ((4.95, 0.0, 5.05, 4.65), (4.95, 5.35, 5.05, 10.0)),
                 (1.0, 1.0)).site().floor
    made = pieces(0.7)
    assert any(piece.control is not None for piece in made), (
        'there must be bends, because there is room')
    for piece in made:
        ends = floor.clearance_at(np.array((piece.start, piece.end)))
        assert ends.min() >= OPTIONS.turning - 0.03
        if piece.control is not None:
            assert room(piece, floor) >= OPTIONS.turning - 0.03


def test_a_wide_opening_may_be_passed_in_a_bend():
    made = pieces(3.0)
    assert sum(piece.control is not None for piece in made) == 2


def test_a_lane_with_no_room_to_turn_anywhere_still_bends():
    """Without a bend, a robot would have to turn at a place where it cannot."""
    corners = ((4.2, 5.0), (5.0, 5.0), (6.0, 5.8))
    made = pieces(0.8, corners)
    assert [piece.control is not None for piece in made].count(True) == 1
