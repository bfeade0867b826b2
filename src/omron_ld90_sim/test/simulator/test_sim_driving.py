"""The robot's motion: it never touches anything and keeps its limits at every step."""
from __future__ import annotations

import math
from pathlib import Path
from typing import Tuple

import numpy as np
import pytest
from sim_builders import LAB, REAL_MAPS, Obstacles, Rig
from skimage.measure import label

from omron_ld90.maps import MapDocument
from omron_ld90_sim.floor import Floor
from omron_ld90_sim.kinematics import LD90_BODY, LD90_LIMITS, Pose, normalise
from omron_ld90_sim.motion import STEP, Base
from omron_ld90_sim.planner import Disc, NoWay, Planner
from omron_ld90_sim.track import Turn, manoeuvres

PAIRS = 200
MAPS = [LAB, REAL_MAPS / 'omron-ld-site-a.map', REAL_MAPS / 'omron-ld-site-b.map']


def random_pairs(floor: Floor, planner: Planner, near: Tuple[float, float], count: int):
    """Random poses with room to turn, in the part of the floor connected with `near`."""
    connected = label(floor.planning_clearance >= planner.drive_clearance, connectivity=1)
    part = connected == connected[floor.planning_cell(*near)]
    cells = np.argwhere(part & (floor.planning_clearance >= planner.turn_clearance))
    assert len(cells) > 100, 'hardly any room around that goal'
    random = np.random.RandomState(5)
    for _ in range(count):
        start, goal = floor.planning_points(cells[random.randint(len(cells), size=2)])
        yield (Pose(start[0], start[1], random.uniform(-180, 180)),
               Pose(goal[0], goal[1], random.uniform(-180, 180)))


class Inspector:
    """Steps a base to its end and checks every step against obstacles and limits."""

    def __init__(self, obstacles: Obstacles) -> None:
        self.obstacles = obstacles

    def drive(self, base: Base, seconds: float = 1000.0) -> None:
        # no border of an area is ever touched, so it is enough that the start is outside
        assert not self.obstacles.forbidden(base.pose)
        limits, left = LD90_LIMITS, seconds
        speed = rotation = 0.0
        while not base.still:
            before, turning = base.pose, isinstance(base.manoeuvre, Turn)
            base.step()
            left -= STEP
            assert left > 0, 'the robot does not arrive'
            moved = base.pose.distance_to(before.x, before.y) / STEP
            turned = abs(normalise(base.pose.theta - before.theta)) / STEP
            where = f'at {base.pose}'
            assert base.speed <= limits.speed + 1e-6, where
            assert -limits.deceleration <= (base.speed - speed) / STEP + 1e-6, where
            assert (base.speed - speed) / STEP <= limits.acceleration + 1e-6, where
            spin = abs(base.rotation - rotation) / STEP
            assert spin <= limits.rotation_acceleration + 1e-6, where
            assert turned <= limits.path_rotation + 1e-6, where
            assert abs(moved - (speed + base.speed) / 2) < 8.0, f'{where}: jumped'
            clear = self.obstacles.clearance(base.pose)
            assert self.obstacles.distance(base.pose) > 0.0, f'{where}: touched'
            assert clear >= LD90_BODY.half_width, where
            assert not turning or clear >= LD90_BODY.half_diagonal, where
            speed, rotation = base.speed, base.rotation


@pytest.mark.parametrize('path', MAPS, ids=lambda path: path.stem)
def test_between_random_poses_the_body_touches_nothing(path: Path) -> None:
    if not path.exists():
        pytest.skip(f'{path.name} is not here')
    document = MapDocument.load(str(path))
    floor = Floor.from_map(document)
    planner = Planner(floor)
    inspector = Inspector(Obstacles(document))
    first = document.goals[0]
    for start, end in random_pairs(floor, planner, (first.x, first.y), PAIRS):
        way = planner.plan(start, end.x, end.y, end.theta)
        base = Base(start)
        base.follow(manoeuvres(way, planner))
        inspector.drive(base)
        assert base.pose.distance_to(end.x, end.y) < 1.0
        assert abs(normalise(base.pose.theta - end.theta)) < 0.1


def lonely_floor(*walls: Tuple[float, float, float, float]) -> Floor:
    everything = np.array([[-5000, -4000, 5000, -4000], [-5000, 4000, 5000, 4000],
                           [-5000, -4000, -5000, 4000], [5000, -4000, 5000, 4000], *walls], float)
    return Floor(np.empty((0, 2)), everything, np.empty((0, 4)), [], 20, np.empty((0, 2)))


def test_a_door_too_narrow_to_turn_in_is_driven_through_straight() -> None:
    floor = lonely_floor((0, -4000, 0, -330), (0, 330, 0, 4000))
    planner = Planner(floor)
    way = planner.plan(Pose(-3000.0, 2000.0, 0.0), 3000.0, -2000.0)
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
        planner.plan(Pose(-3000.0, 2000.0, 0.0), 3000.0, -2000.0)


def test_a_corridor_of_900_mm_with_a_bend_can_be_driven() -> None:
    # an L: along y = 0 from the left, then up along x = 0
    floor = lonely_floor((-5000, 450, -450, 450), (-450, 450, -450, 4000),
                         (-5000, -450, 450, -450), (450, -450, 450, 4000))
    planner = Planner(floor)
    way = planner.plan(Pose(-4000.0, 0.0, 0.0), 0.0, 3500.0)
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    while not base.still:
        base.step()
        outline = LD90_BODY.corners(base.pose)
        assert floor.clearance_at(outline).min() > 0.0, f'touched at {base.pose}'
    assert base.pose.distance_to(0.0, 3500.0) < 1.0


def test_out_of_a_niche_the_robot_backs_up_before_it_turns() -> None:
    floor = lonely_floor((2000, -330, 5000, -330), (2000, 330, 5000, 330))
    planner = Planner(floor)
    way = planner.plan(Pose(4000.0, 0.0, 0.0), -3000.0, 0.0)
    assert way.escape < -1500.0


def test_around_an_obstacle_that_is_not_on_the_map() -> None:
    planner = Planner(lonely_floor())
    disc = Disc(0.0, 0.0, 400.0)
    way = planner.plan(Pose(-3000.0, 0.0, 0.0), 3000.0, 0.0, obstacles=[disc])
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    nearest = math.inf
    while not base.still:
        base.step()
        nearest = min(nearest, base.pose.distance_to(0.0, 0.0))
    assert 400.0 + LD90_BODY.half_width <= nearest < 1500.0


def test_the_robot_brakes_for_a_goal_from_metres_away() -> None:
    planner = Planner(lonely_floor())
    base = Base(Pose(-4500.0, 0.0, 0.0))
    base.follow(manoeuvres(planner.plan(base.pose, 4500.0, 0.0), planner))
    braking_from = None
    while not base.still:
        before = base.speed
        base.step()
        if braking_from is None and base.speed < before:
            braking_from = 4500.0 - base.pose.x
            fastest = before
    expected = fastest ** 2 / (2 * LD90_LIMITS.goal_deceleration)
    assert braking_from == pytest.approx(expected, abs=100.0)
    assert fastest > 1200.0


def test_a_new_goal_straight_ahead_is_taken_without_slowing_down() -> None:
    rig = Rig(start=(-3000.0, 2200.0, 0.0))
    client = rig.client()
    client.send('gotoPoint 0 2200')
    while rig.robot.base.speed < 600.0:
        rig.clock.advance(rig.clock.now + STEP)
    client.send('gotoPoint 5000 2200')
    slowest = math.inf
    while rig.robot.true_pose.x < 0.0:
        rig.clock.advance(rig.clock.now + STEP)
        slowest = min(slowest, rig.robot.base.speed)
    assert slowest >= 600.0


def test_a_new_goal_behind_is_taken_within_the_limits() -> None:
    rig = Rig(start=(-3000.0, 2200.0, 0.0))
    client = rig.client()
    client.send('gotoPoint 5000 2200')
    rig.clock.advance(4.0)
    client.send('gotoPoint -3000 2200')
    client.lines()
    speed = rig.robot.base.speed
    while not rig.robot.base.still:
        rig.clock.advance(rig.clock.now + STEP)
        now = rig.robot.base.speed
        assert abs(now - speed) <= 500.0 * STEP + 1e-6
        speed = now
    assert rig.robot.true_pose.distance_to(-3000.0, 2200.0) < 1.0


def test_two_robots_give_way_or_stop_but_never_touch() -> None:
    left = Rig(start=(-3000.0, 2200.0, 0.0))
    right = Rig(start=(5000.0, 2200.0, 180.0))
    left.robot.neighbours, right.robot.neighbours = [right.robot], [left.robot]
    one, two = left.client(), right.client()
    one.send('gotoPoint 5000 1000')
    two.send('gotoPoint -3000 1000')
    nearest = math.inf
    for _ in range(2400):
        for rig in (left, right):
            rig.clock.advance(rig.clock.now + STEP)
        other = right.robot.true_pose
        nearest = min(nearest, left.robot.true_pose.distance_to(other.x, other.y))
    assert nearest > LD90_BODY.width, f'they came as near as {nearest:.0f} mm'
    assert 'Arrived at point' in one.lines() + two.lines()
