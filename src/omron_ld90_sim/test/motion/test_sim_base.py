"""The moving base respects its limits and its distance to obstacles at every step."""
from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Tuple

import numpy as np
import pytest
from hypothesis import settings
from motion_inspector import Inspector
from sim_builders import MAPS, Obstacles, Rig, corridor, lonely_floor
from skimage.measure import label

from omron_ld90_sim.motion.base import STEP, Base
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import LD90_LIMITS, SimPose, normalise
from omron_ld90_sim.motion.manoeuvres import manoeuvres
from omron_ld90_sim.motion.planner import Planner
from omron_map import MapDocument

PAIRS = 2 * settings.default.max_examples


def random_pairs(floor: SimFloor, planner: Planner, near: Tuple[float, float], count: int):
    """Yields pairs of random poses with room to turn, in the part of the floor around `near`."""
    connected = label(floor.planning_clearance >= planner.drive_clearance, connectivity=1)
    part = connected == connected[floor.planning_cell(*near)]
    cells = np.argwhere(part & (floor.planning_clearance >= planner.turn_clearance))
    assert len(cells) > 100, 'there is hardly any room around that goal'
    random = np.random.RandomState(5)
    for _ in range(count):
        start, goal = floor.planning_points(cells[random.randint(len(cells), size=2)])
        yield (SimPose(start[0], start[1], random.uniform(-180, 180)),
               SimPose(goal[0], goal[1], random.uniform(-180, 180)))


@pytest.mark.parametrize('path', MAPS, ids=lambda path: path.stem)
def test_between_random_poses_the_body_touches_nothing(path: Path) -> None:
    if not path.exists():
        pytest.skip(f'{path.name} does not exist')
    document = MapDocument.load(str(path))
    floor = SimFloor.from_map(document)
    planner = Planner(floor)
    obstacles = Obstacles(document)
    first = document.goals[0]
    for start, end in random_pairs(floor, planner, (first.x, first.y), PAIRS):
        way = planner.plan(start, end.x, end.y, end.theta)
        base = Base(start)
        base.follow(manoeuvres(way, planner))
        Inspector(obstacles, base).drive()
        assert base.pose.distance_to(end.x, end.y) < 1.0
        assert abs(normalise(base.pose.theta - end.theta)) < 0.1


def test_a_sharp_corner_too_near_the_last_one_to_be_driven_round_is_turned_in() -> None:
    document = corridor(6000.0)
    planner = Planner(SimFloor.from_map(document))
    way = planner.plan(SimPose(0.0, -1500.0, 42.0), 1280.0, 760.0)
    corners = np.array([[0.0, -1500.0], [920.0, -660.0], [800.0, -680.0], [1280.0, 760.0]])
    base = Base(way.start)
    base.follow(manoeuvres(replace(way, vertices=corners), planner))
    Inspector(Obstacles(document), base).drive()


def test_the_robot_brakes_for_a_goal_from_metres_away() -> None:
    planner = Planner(lonely_floor())
    base = Base(SimPose(-4500.0, 0.0, 0.0))
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


def test_an_emergency_stop_brakes_hard_but_turns_no_harder_than_ever() -> None:
    rig = Rig(start=(-3000.0, 2200.0, 0.0))
    client = rig.client()
    client.send('goto 12')  # around the end of the wall
    while abs(rig.robot.base.rotation) < 30.0 or rig.robot.base.speed < 300.0:
        rig.clock.advance(rig.clock.now + STEP)
    start = rig.robot.base.speed
    rig.robot.permission.press_estop()
    client.send('stop')  # a second stop must not weaken the first one
    steps = []
    while not rig.robot.base.still:
        before = rig.robot.base.speed, rig.robot.base.rotation
        rig.clock.advance(rig.clock.now + STEP)
        steps.append((before[0] - rig.robot.base.speed, before[1] - rig.robot.base.rotation))
    braked, spun = np.abs(steps).max(axis=0) / STEP
    assert spun <= LD90_LIMITS.rotation_acceleration + 1e-6
    assert braked <= LD90_LIMITS.emergency_deceleration + 1e-6
    assert len(steps) * STEP < start / LD90_LIMITS.deceleration, (
        'it must stop faster than with normal braking')
