"""Paths on a floor: found if there is one, refused if there is none."""
from __future__ import annotations

import math

import numpy as np
import pytest
from sim_builders import lonely_floor

from omron_ld90_sim.motion.base import Base
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import LD90_BODY, SimPose
from omron_ld90_sim.motion.manoeuvres import manoeuvres
from omron_ld90_sim.motion.planner import NoWay, Planner
from omron_ld90_sim.motion.space import Disc


def test_a_door_too_narrow_to_turn_in_is_driven_through_straight() -> None:
    floor = lonely_floor((0, -4000, 0, -330), (0, 330, 0, 4000))
    planner = Planner(floor)
    way = planner.plan(SimPose(-3000.0, 2000.0, 0.0), 3000.0, -2000.0)
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    while not base.still:
        base.step()
        if abs(base.pose.x) < 400.0:
            corners = LD90_BODY.corners(base.pose)
            assert np.abs(corners[np.abs(corners[:, 0]) < 50.0, 1]).max(initial=0.0) < 330.0
    assert base.pose.distance_to(3000.0, -2000.0) < 1.0


def test_a_door_narrower_than_the_robot_is_no_way() -> None:
    planner = Planner(lonely_floor((0, -4000, 0, -250), (0, 250, 0, 4000)))
    with pytest.raises(NoWay):
        planner.plan(SimPose(-3000.0, 2000.0, 0.0), 3000.0, -2000.0)


@pytest.mark.parametrize('width', [600.0, 620.0, 650.0])
def test_a_slanting_passage_out_of_a_spot_where_it_can_just_turn_is_driven(width) -> None:
    # a dead-end corridor of 940 mm along y = 0; near its end a passage leads up, slightly right
    through = np.array([math.cos(math.radians(65.0)), math.sin(math.radians(65.0))])
    aside = np.array([-through[1], through[0]]) * width / 2.0
    left, right = (side + through * (470.0 - side[1]) / through[1] for side in (aside, -aside))
    ends = [side + 700.0 * through for side in (left, right)]
    planner = Planner(lonely_floor(
        (-5000, -470, 530, -470), (530, -470, 530, 470), (-5000, 470, *left),
        (*left, *ends[0]), (*ends[0], -5000, ends[0][1]),
        (*right, *ends[1]), (*ends[1], 5000, ends[1][1])))
    places = (-3000.0, 0.0), tuple(2600.0 * through)
    for start, goal in (places, places[::-1]):
        way = planner.plan(SimPose(*start, 0.0), *goal)
        assert way.space.clearance_at(way.vertices).min() >= planner.turn_clearance
        for a, b in zip(way.vertices, way.vertices[1:]):
            assert way.space.straight_is_free(a, b, planner.drive_clearance)


def test_a_detour_of_many_metres_is_found() -> None:
    outside = np.array([[-20000, -15000, 20000, -15000], [-20000, 15000, 20000, 15000],
                        [-20000, -15000, -20000, 15000], [20000, -15000, 20000, 15000],
                        [0, -15000, 0, 13000]], float)      # a wall with a gap at its far end
    planner = Planner(SimFloor(np.empty((0, 2)), outside, np.empty((0, 4)), [], 20,
                               np.empty((0, 2))))
    way = planner.plan(SimPose(-1000.0, -5000.0, 0.0), 1000.0, -5000.0)
    assert 36_000.0 < way.length < 40_000.0
    near = planner.plan(SimPose(-1000.0, -5000.0, 0.0), -4000.0, -5000.0)
    assert near.length < 3_010.0


def test_a_corridor_of_900_mm_with_a_bend_can_be_driven() -> None:
    # an L: from the left along y = 0, then up along x = 0
    floor = lonely_floor((-5000, 450, -450, 450), (-450, 450, -450, 4000),
                         (-5000, -450, 450, -450), (450, -450, 450, 4000))
    planner = Planner(floor)
    way = planner.plan(SimPose(-4000.0, 0.0, 0.0), 0.0, 3500.0)
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    while not base.still:
        base.step()
        outline = LD90_BODY.corners(base.pose)
        assert floor.clearance_at(outline).min() > 0.0, f'collision at {base.pose}'
    assert base.pose.distance_to(0.0, 3500.0) < 1.0


def test_out_of_a_niche_the_robot_backs_up_before_it_turns() -> None:
    floor = lonely_floor((2000, -330, 5000, -330), (2000, 330, 5000, 330))
    planner = Planner(floor)
    way = planner.plan(SimPose(4000.0, 0.0, 0.0), -3000.0, 0.0)
    assert way.escape < -1500.0


def test_around_an_obstacle_that_is_not_on_the_map() -> None:
    planner = Planner(lonely_floor())
    disc = Disc(0.0, 0.0, 400.0)
    way = planner.plan(SimPose(-3000.0, 0.0, 0.0), 3000.0, 0.0, obstacles=[disc])
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    nearest = math.inf
    while not base.still:
        base.step()
        nearest = min(nearest, base.pose.distance_to(0.0, 0.0))
    assert 400.0 + LD90_BODY.half_width <= nearest < 1500.0
